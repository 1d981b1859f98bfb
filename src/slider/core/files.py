"""Atomic writing of files, and digests of files, folders and plain values."""

import hashlib
import json
import math
import os
import stat
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from slider.core.errors import not_read

TEMPORARY_PATTERN = ".*.part"


@dataclass(frozen=True)
class FileEntry:
    """Digest and size [bytes] of a file."""

    sha256: str
    size: int


FileTable = dict[str, FileEntry]
"""Files of a folder by relative POSIX path."""


def write_atomic(path: Path, text: str) -> None:
    """Replace a file atomically; a reader sees the old or the new text."""
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with part.open("w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        part.replace(path)
        sync(path.parent, path.parent.parent)
    except OSError as error:  # for a full disk it names no file
        raise OSError(error.errno, error.strerror, str(path)) from None
    finally:
        with suppress(OSError):  # on a read-only disk
            part.unlink(missing_ok=True)


def sync(*paths: Path) -> None:
    """Flush files, or the entries of folders, to disk, so that they survive a power failure."""
    for path in paths:
        descriptor = os.open(path, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        except OSError:
            if path.is_file():  # some file systems cannot sync folders
                raise
        finally:
            os.close(descriptor)


def entries(folder: Path) -> list[Path]:
    """Sorted entries of a folder; empty if it does not exist.

    Raises:
        NotReadError: it cannot be listed, is not a folder, or is a dangling link.
    """
    try:
        return [folder / name for name in sorted(os.listdir(folder))]
    except OSError as error:
        if isinstance(error, FileNotFoundError) and not folder.is_symlink():
            return []
        raise not_read(error, folder) from None


def write_json(path: Path, value: Any) -> None:
    """Write standard JSON atomically; infinities and NaN become the strings inf, -inf, nan."""
    text = json.dumps(plain(value), indent=1, ensure_ascii=False, allow_nan=False)
    write_atomic(path, text + "\n")


def read_json(path: Path) -> Any:
    """Parse a JSON file.

    Raises:
        ValueError: it is not JSON, or nested too deeply.
    """
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except RecursionError:
        raise ValueError("expected JSON, found thousands of brackets") from None


def canonical(value: Any) -> str:
    """JSON without spaces; keys keep their order, since the order of term tables matters."""
    return json.dumps(value, separators=(",", ":"), ensure_ascii=False, allow_nan=False)


def digest_value(value: Any) -> str:
    """SHA-256 of the canonical JSON of a plain value."""
    return digest_text(canonical(value))


def digest_text(text: str) -> str:
    """SHA-256 of a text."""
    return hashlib.sha256(text.encode()).hexdigest()


def digest_file(path: Path) -> str:
    """SHA-256 of a file's bytes."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def list_files(folder: Path) -> list[str]:
    """Relative POSIX paths of all files of a folder, sorted.

    Raises:
        OSError: a folder cannot be listed.
        ValueError: an entry is neither a regular file nor a folder, such as a link.
    """
    names, waiting = [], [folder]
    while waiting:
        for path in waiting.pop().iterdir():
            mode = path.lstat().st_mode
            if stat.S_ISDIR(mode):
                waiting.append(path)
            elif stat.S_ISREG(mode):
                names.append(path.relative_to(folder).as_posix())
            else:
                raise ValueError(f"expected files and folders, found another kind: {path}")
    return sorted(names)


def file_table(folder: Path) -> FileTable:
    """Digest and size of every file of a folder."""
    paths = {name: folder / name for name in list_files(folder)}
    return {name: FileEntry(digest_file(p), p.stat().st_size) for name, p in paths.items()}


def digest_table(table: FileTable) -> str:
    """Digest of a folder's content: of its sorted paths and the digests of their files."""
    return digest_value([[name, table[name].sha256] for name in sorted(table)])


def plain(value: Any) -> Any:
    """Value in types of JSON; infinities and NaN become the strings inf, -inf, nan."""
    if isinstance(value, Mapping):
        return {str(name): plain(item) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if hasattr(value, "tolist"):  # numpy and torch scalars and arrays
        return plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return value


def flatten(node: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Flatten nested mappings: ``{"a": {"b": 1}}`` becomes ``{"a.b": 1}``."""
    flat: dict[str, Any] = {}
    for name, value in node.items():
        if isinstance(value, Mapping):
            flat |= flatten(value, f"{prefix}{name}.")
        else:
            flat[f"{prefix}{name}"] = value
    return flat
