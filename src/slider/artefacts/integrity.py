"""How the files of an object looked when its content was last read and had the object's name.

As in git's index, content whose files still have the same inodes, sizes and times is not read
again. A file that was written just before it was read could change again within one tick of the
file system's clock and look the same, so such a young object gets no entry.
"""

import os
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from slider.core import files

_TICK = 2_000_000_000  # of the coarsest clock of a file system [ns]


@dataclass(frozen=True)
class IntegrityIndex:
    """Entries of objects by their digest, one small file each; a lost one costs a reading."""

    root: Path

    def is_whole(self, digest: str, folder: Path) -> bool:
        """Tell whether a folder's content has its name; read it only if it may have changed."""
        with suppress(OSError, ValueError):
            if self._path(digest).read_text(encoding="utf-8") == _look(folder)[0]:
                return True
        return self.read(digest, folder)

    def read(self, digest: str, folder: Path) -> bool:
        """Read every byte of a folder; tell whether its content has its name, and note it if so."""
        try:
            (look, changed), now = _look(folder), self.now()
            whole = files.digest_table(files.file_table(folder)) == digest
        except (OSError, ValueError):
            return False
        if whole and changed < now - _TICK:
            path = self._path(digest)
            with suppress(OSError):  # no space, or no right: the next one reads the object again
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(look, encoding="utf-8")  # what is torn matches nothing
        return whole

    def drop(self, digest: str) -> None:
        """Forget an object."""
        self._path(digest).unlink(missing_ok=True)

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


def _look(folder: Path) -> tuple[str, int]:
    """Inode, size, times and path of each file, as a text; the latest of the times [ns]."""
    entries = sorted(_walk(str(folder), ""))
    text = "".join(f"{' '.join(map(str, numbers))} {name}\n" for name, *numbers in entries)
    return text, max((max(entry[-2:]) for entry in entries), default=0)


def _walk(folder: str, prefix: str) -> Iterator[tuple[str, int, int, int, int]]:
    with os.scandir(folder) as entries:
        for entry in entries:
            if entry.is_dir(follow_symlinks=False):
                yield from _walk(entry.path, f"{prefix}{entry.name}/")
            else:
                facts = entry.stat(follow_symlinks=False)
                times = facts.st_mtime_ns, facts.st_ctime_ns
                yield f"{prefix}{entry.name}", facts.st_ino, facts.st_size, *times
