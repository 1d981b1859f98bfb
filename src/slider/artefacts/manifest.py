"""Manifests: the result of a recipe, and the file format for it."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any

from pydantic import TypeAdapter

from slider.core import files
from slider.core.errors import NotReadError, UserError, not_read
from slider.core.files import FileTable

SCHEMA = 4


@dataclass(frozen=True)
class Result:
    """What a stage produced: the object, its files and a deterministic summary."""

    object: str
    files: FileTable
    summary: dict[str, Any]

    @property
    def size(self) -> int:
        """Size of all files [bytes]."""
        return sum(entry.size for entry in self.files.values())


@dataclass(frozen=True)
class Manifest:
    """The result of a recipe, without run metadata.

    ``inputs`` are the recipes of the inputs by name, ``input_objects`` their objects, whose content
    was verified before use. The entry ``key`` of the store's index holds the same result.
    """

    stage: str
    recipe: str
    inputs: Mapping[str, Sequence[str]]
    result: Result
    input_objects: Mapping[str, Sequence[str]] = field(default_factory=dict)
    key: str = field(default="", compare=False)


_MANIFESTS = TypeAdapter(Manifest)


def damaged(stage: str, digest: str) -> UserError:
    """Error about a result whose content does not match its digest."""
    return UserError(
        f"expected an intact {stage} result {digest[:12]}, "
        "found it damaged: run `slider store verify`"
    )


def parse_manifest(path: Path) -> Manifest:
    """Read a manifest file.

    Raises:
        UserError: there is none, or it is damaged.
        NotReadError: it cannot be read.
    """
    try:
        manifest = manifest_from(files.read_json(path))
    except FileNotFoundError:
        raise UserError(f"expected a manifest, found none at {path}") from None
    except OSError as error:
        raise not_read(error, path) from None
    except ValueError:
        raise UserError(f"expected a manifest, found something else in {path}") from None
    if path.stem not in (manifest.recipe, manifest.key):
        raise UserError(f"expected a manifest, found that of another job in {path}")
    return manifest


def readable(path: Path) -> Manifest | None:
    """The manifest in a file, or None if it is missing, damaged or of another version.

    Raises:
        NotReadError: it cannot be read.
    """
    try:
        return parse_manifest(path)
    except NotReadError:
        raise
    except UserError:
        return None


def manifest_from(values: Any) -> Manifest:
    """Validate plain values, such as the content of a file, and convert them to a manifest.

    Raises:
        ValueError: the values are not a manifest, or do not match its digest.
    """
    manifest = _MANIFESTS.validate_python(values)
    if plain_manifest(manifest) != values:  # including the digest
        raise ValueError("expected the values that were written, found others")
    table = manifest.result.files
    if not all(map(_is_plain, table)):
        raise ValueError("expected plain names of files below a folder")
    if files.digest_table(table) != manifest.result.object:
        raise ValueError("expected the files of the object")
    return manifest


def _is_plain(name: str) -> bool:
    """Whether a name is a normalised relative path that does not leave its folder."""
    path = PurePosixPath(name)
    below = bool(path.parts) and not path.is_absolute() and ".." not in path.parts
    return below and name.isprintable() and str(path) == name


def plain_manifest(manifest: Manifest) -> dict[str, Any]:
    """A manifest as plain values, with a digest of these values."""
    values = {"schema": SCHEMA, **files.plain(asdict(manifest))}
    return values | {"digest": files.digest_value(values)}
