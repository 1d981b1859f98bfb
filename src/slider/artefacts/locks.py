"""Locks between processes: one job per recipe, and no clean-up while jobs run.

The operating system holds them: they vanish with the process that holds them, however it ends.
"""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from filelock import FileLock, Timeout

from slider.core.errors import UserError

_GATE = "all"  # whoever holds every lock keeps this one, so that no new one is taken


@contextmanager
def exclusive(folder: Path, name: str, timeout: float = -1) -> Iterator[None]:
    """Hold the lock of a name; wait until no other process holds it, nor all locks.

    Raises:
        Timeout: another process still holds the name after so many seconds; -1 waits for ever.
        UserError: there is no place for a lock file.
    """
    with _held(folder, name, timeout):
        with _held(folder, _GATE):
            pass
        try:
            yield
        finally:
            _path(folder, name).unlink(missing_ok=True)  # a process that waits for it notices


@contextmanager
def nobody_else(folder: Path) -> Iterator[None]:
    """Hold every lock at once.

    Raises:
        UserError: some job is running, or there is no place for a lock file.
    """
    with ExitStack() as held:
        try:
            held.enter_context(_held(folder, _GATE, timeout=0))
            for path in folder.glob("*.lock"):
                if path.stem != _GATE:
                    held.enter_context(_held(folder, path.stem, timeout=0))
                    held.callback(path.unlink, missing_ok=True)  # left by a killed job
        except Timeout:
            raise UserError(f"expected no running job in {folder.parent}, found one") from None
        yield


@contextmanager
def _held(folder: Path, name: str, timeout: float = -1) -> Iterator[None]:
    path = _path(folder, name)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = FileLock(path, timeout)
        lock.acquire()
    except Timeout:  # an OSError, too
        raise
    except (OSError, NotImplementedError) as error:
        found = getattr(error, "strerror", "a file system without locks")
        raise UserError(f"expected a lock file at {path}, found: {found}") from None
    try:
        yield
    finally:
        lock.release()


def _path(folder: Path, name: str) -> Path:
    return folder / f"{name}.lock"
