"""Manifests: what a recipe led to, as it is written and read."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from slider.core import files
from slider.core.errors import UserError
from slider.core.files import FileTable

SCHEMA = 1


@dataclass(frozen=True)
class Result:
    """What a stage produced: the object, its files and a few deterministic facts.

    ``resumed`` is the one trace of a run's history that is kept here: a training that was resumed
    from a checkpoint is not bit-equal to an uninterrupted one, and who uses it must know.
    """

    object: str
    files: FileTable
    summary: dict[str, Any]
    resumed: bool = False

    @property
    def size(self) -> int:
        """Size of all files [bytes]."""
        return sum(facts["size"] for facts in self.files.values())


@dataclass(frozen=True)
class Manifest:
    """The result of a recipe and the recipes of its inputs. Holds nothing volatile.

    ``input_objects`` are the inputs' objects, whose content was checked before it was computed
    from them; an earlier version of this package noted none.
    """

    stage: str
    recipe: str
    inputs: Mapping[str, Sequence[str]]
    result: Result
    input_objects: Mapping[str, Sequence[str]] = field(default_factory=dict)


def damaged(stage: str, digest: str) -> UserError:
    """What is said of a result whose content is not what its name says."""
    return UserError(
        f"expected the {stage} result {digest[:12]} whole, "
        "found it damaged: run `slider store verify`"
    )


def parse_manifest(path: Path) -> Manifest:
    """Read a manifest file.

    Raises:
        UserError: there is none, or it is not one of ours.
    """
    try:
        return manifest_from(files.read_json(path))
    except FileNotFoundError:
        raise UserError(f"expected a manifest, found none at {path}") from None
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        raise UserError(f"expected a manifest, found something else in {path}") from None


def readable(path: Path) -> Manifest | None:
    """A manifest file, if it is one of ours."""
    try:
        return parse_manifest(path)
    except UserError:
        return None


def manifest_from(values: Any) -> Manifest:
    """The manifest of plain values.

    Raises:
        ValueError, KeyError, TypeError, AttributeError: they are none of ours.
    """
    result = Result(
        values["object"], values["files"], values["summary"], values.get("resumed", False)
    )
    inputs, objects = values["inputs"], values.get("input_objects", {})
    manifest = Manifest(values["stage"], values["recipe"], inputs, result, objects)
    typed = (
        (result.files, dict),
        (result.summary, dict),
        (result.resumed, bool),
        (manifest.stage, str),
        (manifest.recipe, str),
        *((facts["size"], int) for facts in result.files.values()),
    )
    if any(type(value) is not kind for value, kind in typed) or not (
        _is_groups(inputs) and _is_groups(objects)
    ):
        raise TypeError("expected tables and names")
    if files.digest_table(result.files) != result.object:
        raise ValueError("expected the files of the object")
    return manifest


def _is_groups(values: Any) -> bool:
    """Tell whether a value is names with lists of digests."""
    lists = list(values.values()) if isinstance(values, dict) else [None]
    return all(isinstance(group, list) and all(type(d) is str for d in group) for group in lists)


def plain_manifest(manifest: Manifest) -> dict[str, Any]:
    """A manifest as plain values."""
    values = {"schema": SCHEMA, **asdict(manifest)}
    values |= values.pop("result")
    if not manifest.result.resumed:
        del values["resumed"]
    return values
