"""Recipes: digests of everything that may change the result of a stage."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import slider
from slider.artefacts.source import closure
from slider.artefacts.versions import versions
from slider.core.files import digest_value

SOURCE_ROOT = Path(slider.__file__).parent.parent

Groups = Mapping[str, Sequence[str]]
"""Name of an input → digests, in order."""


@dataclass(frozen=True)
class Code:
    """What runs: the entry point ``module:function``, its source digest, third-party versions."""

    entry: str
    source: str
    versions: dict[str, str]


@cache
def code_of(entry: str, root: Path = SOURCE_ROOT) -> Code:
    """Source digest and third-party versions of an entry point.

    Raises:
        UserError: the module does not exist, does not parse or imports an unknown package.
    """
    found = closure(entry.partition(":")[0], root)
    return Code(entry, found.digest, versions(found.third_party))


def recipe_digest(stage: str, section: Any, code: Code, inputs: Groups) -> str:
    """Name a result before it exists; ``inputs`` holds the recipes of the inputs.

    With the digests of the inputs' objects in their place it is the key of the index: what
    counts there is the content of the inputs, not the way in which they came about.
    """
    groups = {name: list(digests) for name, digests in inputs.items()}
    return digest_value([stage, section, code.entry, code.source, code.versions, groups])
