"""Manifests: what a recipe led to, as it is written and read."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any

from slider.core import files
from slider.core.errors import UserError
from slider.core.files import FileTable

SCHEMA = 2
_LONGEST_NAME, _DEEPEST = 255, 32  # bytes of a name, which file systems allow; folders in folders


@dataclass(frozen=True)
class Result:
    """What a stage produced: the object, its files and a few deterministic facts.

    ``resumed`` is the only trace of a run's history here: a training that was resumed from a
    checkpoint is not bit-equal to an uninterrupted one.
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
    """The result of a recipe; holds nothing volatile.

    Attributes:
        stage: name of the stage.
        recipe: of the job.
        inputs: recipes of the inputs by name.
        result: object and facts.
        input_objects: objects of the inputs, whose content was checked before they were used.
        key: of the entry of the store's index that holds the same result.
    """

    stage: str
    recipe: str
    inputs: Mapping[str, Sequence[str]]
    result: Result
    input_objects: Mapping[str, Sequence[str]] = field(default_factory=dict)
    key: str = field(default="", compare=False)


def damaged(stage: str, digest: str) -> UserError:
    """The error of a result whose content is not what its name says."""
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
        manifest = manifest_from(files.read_json(path))
    except FileNotFoundError:
        raise UserError(f"expected a manifest, found none at {path}") from None
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        raise UserError(f"expected a manifest, found something else in {path}") from None
    if path.stem not in (manifest.recipe, manifest.key):
        raise UserError(f"expected a manifest, found that of another job in {path}")
    return manifest


def readable(path: Path) -> Manifest | None:
    """A manifest file, if it is one of ours."""
    try:
        return parse_manifest(path)
    except UserError:
        return None


def manifest_from(values: Any) -> Manifest:
    """The manifest of plain values, such as those of a file; nothing in them is trusted.

    Raises:
        ValueError, KeyError, TypeError, AttributeError: they are none of ours, or were changed.
    """
    unsigned = {name: value for name, value in values.items() if name != "digest"}
    if values["digest"] != files.digest_value(unsigned):
        raise ValueError("expected the values that were written, found others")
    table, summary, resumed = values["files"], values["summary"], values.get("resumed", False)
    inputs, objects = values["inputs"], values["input_objects"]
    result = Result(values["object"], table, summary, resumed)
    manifest = Manifest(values["stage"], values["recipe"], inputs, result, objects, values["key"])
    groups = [*inputs.values(), *objects.values()]
    names = [manifest.stage, manifest.recipe, manifest.key]
    names += [digest for group in groups for digest in group]
    names += [facts["sha256"] for facts in table.values()]
    kinds: dict[type, list[Any]] = {
        dict: [table, summary],
        list: groups,
        str: names,
        int: [facts["size"] for facts in table.values()],
        bool: [resumed],
    }
    if any(type(value) is not kind for kind, group in kinds.items() for value in group):
        raise TypeError("expected tables and names")
    if not _has_plain_names(result.files):
        raise ValueError("expected plain names of files below a folder")
    if files.digest_table(result.files) != result.object:
        raise ValueError("expected the files of the object")
    return manifest


def _has_plain_names(table: FileTable) -> bool:
    """Tell whether all names lead to different files below a folder, in their shortest form."""
    for name in table:
        path = PurePosixPath(name)
        shortest = str(path) == name and 0 < len(path.parts) <= _DEEPEST
        below = not path.is_absolute() and ".." not in path.parts
        plain = name.isprintable() and "\\" not in name
        short = all(len(part.encode()) <= _LONGEST_NAME for part in path.parts)
        if not (shortest and below and plain and short):
            return False
        if any(str(parent) in table for parent in path.parents):
            return False
    return True


def plain_manifest(manifest: Manifest) -> dict[str, Any]:
    """A manifest as plain values, with the digest of all others."""
    values = {"schema": SCHEMA, **asdict(manifest)}
    values |= values.pop("result")
    if not manifest.result.resumed:
        del values["resumed"]
    values = files.plain(values)
    return values | {"digest": files.digest_value(values)}
