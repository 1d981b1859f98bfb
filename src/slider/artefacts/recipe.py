"""Recipes: digests of everything that may change the result of a stage."""

import importlib.util
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import metadata
from pathlib import Path

import slider
from slider.artefacts.closure import Sources, closure
from slider.core.errors import UserError

SOURCE_ROOT = Path(slider.__file__).parent.parent
ABSENT = "absent"

Groups = Mapping[str, Sequence[str]]
"""Name of an input → digests, in order."""


@dataclass(frozen=True)
class Code:
    """What runs: the entry point ``module:function``, its source digest, third-party versions.

    ``parts`` are the digests of the modules and data files behind ``source``, where they are known.
    """

    entry: str
    source: str
    versions: dict[str, str]
    parts: Mapping[str, str] = field(default_factory=dict, compare=False, repr=False)


@cache
def code_of(entry: str, root: Path = SOURCE_ROOT) -> Code:
    """Source digest and third-party versions of an entry point.

    Raises:
        UserError: the module does not exist, does not parse or imports an unknown package.
    """
    found = closure(entry.partition(":")[0], sources_of(root))
    return Code(entry, found.digest, versions(found.third_party), found.parts)


@cache
def sources_of(root: Path) -> Sources:
    """The sources below a folder, for all entry points."""
    return Sources(root)


def versions(packages: Sequence[str]) -> dict[str, str]:
    """Version of Python (major.minor) and of each importable top-level package, sorted.

    One that is not installed is ``absent``.

    Raises:
        UserError: a package can be imported, but no distribution owns up to it.
    """
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    return {"python": python} | {name: _version(name) for name in sorted(packages)}


@cache
def _version(package: str) -> str:
    found = distribution(package)
    return found.version if found else ABSENT


@cache
def distribution(package: str) -> metadata.Distribution | None:
    """Distribution that provides an importable package, if that is installed.

    Raises:
        UserError: the package can be imported, but no distribution owns up to it.
    """
    try:
        return metadata.distribution(package)
    except metadata.PackageNotFoundError:
        return _search(package) if importlib.util.find_spec(package) else None


def _search(package: str) -> metadata.Distribution:
    # metadata.packages_distributions() parses every list of files and takes 0.7 s; the
    # names of two of ten packages differ from their distribution's, so a text search will do.
    # The packages of cmeel (pinocchio) are one folder of site-packages below another.
    markers = (f"\n{package}/", f"\n{package}.py,", f"/site-packages/{package}/__init__.py,")
    for found, record in _records():
        if any(marker in record for marker in markers):
            return found
    raise UserError(f"expected an installed distribution with package {package}, found none")


@cache
def _records() -> list[tuple[metadata.Distribution, str]]:
    """Installed distributions with their lists of files."""
    return [(d, "\n" + (d.read_text("RECORD") or "")) for d in metadata.distributions()]
