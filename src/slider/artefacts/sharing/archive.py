"""An object as one file: an uncompressed tar that depends on the object's content alone.

Many small files are slow to fetch one by one. Neither names nor sizes in an archive are trusted:
only what the table of a manifest lists is unpacked, and its content must have the listed digests.
"""

import shutil
import tarfile
from pathlib import Path, PurePosixPath
from typing import IO

from slider.core import files
from slider.core.files import FileTable


class DamageError(Exception):
    """Content is not what its name says; the text says what was expected and found."""


def pack(folder: Path, table: FileTable, target: Path) -> None:
    """Write the files of an object into an archive; always the same bytes for the same content.

    Raises:
        OSError: a file is missing or shorter than the table says.
    """
    with tarfile.open(target, "w", format=tarfile.PAX_FORMAT) as archive:
        for name in sorted(table):
            with (folder / name).open("rb") as file:
                archive.addfile(_header(name, table[name]["size"]), file)


def packed_size(table: FileTable) -> int:
    """Size of the archive of an object [bytes]."""
    blocks = 2  # the end
    for name, facts in table.items():
        blocks += len(_header(name, facts["size"]).tobuf(tarfile.PAX_FORMAT)) // tarfile.BLOCKSIZE
        blocks += -(-facts["size"] // tarfile.BLOCKSIZE)
    return -(-blocks * tarfile.BLOCKSIZE // tarfile.RECORDSIZE) * tarfile.RECORDSIZE


def unpack(archive: Path, table: FileTable, folder: Path) -> None:
    """Write the files of an archive into an empty folder.

    Raises:
        DamageError: names, sizes or contents are not those of the table.
    """
    if not _is_plain(table):
        raise DamageError("expected plain names of files, found others")
    expected, found = packed_size(table), archive.stat().st_size
    if found != expected:
        raise DamageError(f"expected {expected} bytes, found {found}")
    try:
        with tarfile.open(archive, "r:") as members:
            listed = [(member.name, member.size, member.type) for member in members]
            if listed != [(n, table[n]["size"], tarfile.REGTYPE) for n in sorted(table)]:
                raise DamageError("expected the files of the manifest, found others")
            for name in table:
                _copy(members.extractfile(name), folder / name)
    except (tarfile.TarError, EOFError, ValueError) as error:
        raise DamageError(f"expected an archive, found none ({error})") from None
    if files.file_table(folder) != table:
        raise DamageError("expected the content that its name says, found another")


def _copy(content: IO[bytes] | None, path: Path) -> None:
    assert content is not None  # a regular file has content
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("xb") as target:
        shutil.copyfileobj(content, target)


def _is_plain(table: FileTable) -> bool:
    """Tell whether all names lead to different files below a folder, in their shortest form."""
    for name in table:
        path = PurePosixPath(name)
        if path.is_absolute() or ".." in path.parts or str(path) != name or name == ".":
            return False
        if any(str(parent) in table for parent in path.parents):
            return False
    return True


def _header(name: str, size: int) -> tarfile.TarInfo:
    header = tarfile.TarInfo(name)
    header.size = size
    header.mode = 0o444
    return header
