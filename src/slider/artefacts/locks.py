"""Locks between processes: one job per recipe, and no clean-up while jobs run.

All are byte ranges of one file, so that no litter of lock files stays behind. They vanish with
the process that holds them, however it ends.
"""

import fcntl
import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from slider.core.errors import UserError


@contextmanager
def exclusive(path: Path, name: str) -> Iterator[None]:
    """Wait until no other process holds the lock of this name."""
    path.parent.mkdir(parents=True, exist_ok=True)
    offset = int(hashlib.sha256(name.encode()).hexdigest()[:15], 16)
    # Closing any handle of the file drops all locks of a process: open it only here, once.
    with path.open("ab") as file:
        fcntl.lockf(file, fcntl.LOCK_EX, 1, offset)
        yield


@contextmanager
def nobody_else(path: Path) -> Iterator[None]:
    """Hold every lock at once.

    Raises:
        UserError: some job is running.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("ab") as file:
        try:
            fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise UserError(f"expected no running job in {path.parent}, found one") from None
        yield
