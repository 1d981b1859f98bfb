"""Seals: how the files of an object looked when its content was last read and found whole.

As in git's index, content whose files still have the sealed inodes, sizes and times is not read
again. A file that was written just before it was read could change again within one tick of the
file system's clock and look the same, so that such a young object gets no seal.
"""

import os
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from slider.core import files

_TICK = 2_000_000_000  # of the coarsest clock of a file system [ns]

Look = tuple[str, int, int, int, int]
"""Path, inode, size [bytes], times of the last change of content and of inode [ns]."""


@dataclass(frozen=True)
class Seals:
    """Seals of objects by their digest, one small file each; a lost one costs a reading."""

    root: Path

    def is_whole(self, digest: str, folder: Path) -> bool:
        """Tell whether a folder's content has its name; read it only if it may have changed."""
        try:
            if self._path(digest).read_text() == _text(_looks(folder)):
                return True
        except (OSError, ValueError):
            pass
        return self.read(digest, folder)

    def read(self, digest: str, folder: Path) -> bool:
        """Read a folder, tell whether its content has its name, and seal it if so."""
        try:
            looks, now = _looks(folder), self.now()
            whole = files.digest_table(files.file_table(folder)) == digest
        except (OSError, ValueError):
            return False
        if whole and all(max(look[-2:]) < now - _TICK for look in looks):
            self._write(digest, _text(looks))
        return whole

    def drop(self, digest: str) -> None:
        """Forget an object."""
        self._path(digest).unlink(missing_ok=True)

    def _write(self, digest: str, text: str) -> None:
        with suppress(OSError):  # no space, or not ours: the next one reads the object again
            files.write_atomic(self._path(digest), text)

    def now(self) -> int:
        """Time by the clock of the store's file system [ns]; 0, before all files, without one."""
        try:
            self.root.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=self.root) as file:
                return os.fstat(file.fileno()).st_mtime_ns
        except OSError:
            return 0

    def _path(self, digest: str) -> Path:
        return self.root / digest[:2] / digest


def _looks(folder: Path) -> list[Look]:
    return sorted(_walk(str(folder), ""))


def _walk(folder: str, prefix: str) -> Iterator[Look]:
    with os.scandir(folder) as entries:
        for entry in entries:
            if entry.is_dir(follow_symlinks=False):
                yield from _walk(entry.path, f"{prefix}{entry.name}/")
            else:
                found = entry.stat(follow_symlinks=False)
                times = found.st_mtime_ns, found.st_ctime_ns
                yield f"{prefix}{entry.name}", found.st_ino, found.st_size, *times


def _text(looks: list[Look]) -> str:
    return "".join(f"{' '.join(map(str, numbers))} {name}\n" for name, *numbers in looks)
