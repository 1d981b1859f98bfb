"""What Python does to files, seen by an audit hook: count it, or fail at one of the operations.

See PEP 578 and the table of audit events in the documentation of Python.
"""

import errno
import os
import resource
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

_CHANGES = ("os.rename", "os.remove", "os.mkdir", "os.rmdir", "os.chmod", "os.utime", "os.truncate")
_LISTS = ("os.listdir", "os.scandir")
_WRITE = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC


def at_each(root: Path, act: Callable[[int], object], reading: bool = False) -> None:
    """Call ``act`` with the number of each change below ``root``, or reading, before it happens.

    For the rest of the process: a hook cannot be removed.
    """
    count = 0

    def hook(event: str, arguments: tuple[Any, ...]) -> None:
        nonlocal count
        happens = _reads if reading else _changes
        if happens(event, arguments) and _below(arguments[0], root):
            count += 1
            act(count)

    sys.addaudithook(hook)


def _changes(event: str, arguments: tuple[Any, ...]) -> bool:
    if event == "open":
        return isinstance(arguments[2], int) and bool(arguments[2] & _WRITE)
    return event in _CHANGES


def _reads(event: str, arguments: tuple[Any, ...]) -> bool:
    return event in _LISTS or (event == "open" and not _changes(event, arguments))


def _below(path: Any, root: Path) -> bool:
    """Whether a path is below a folder; one relative to an open folder may be."""
    if isinstance(path, bytes | str | os.PathLike):
        text = os.fsdecode(path)
        return not os.path.isabs(text) or text.startswith(str(root))
    return False


def kill_at(root: Path, number: int) -> Callable[[], None]:
    """End the process without a chance to tidy up before an operation."""
    kill = signal.SIGKILL
    return lambda: at_each(root, lambda count: count == number and signal.raise_signal(kill))


def no_space_from(root: Path, number: int) -> Callable[[], None]:
    """Fail an operation and all that follow, as on a full disk."""
    return lambda: at_each(root, lambda count: count >= number and _fail(root, errno.ENOSPC))


def no_reading_at(root: Path, number: int, code: int) -> Callable[[], None]:
    """Fail one reading with an error of the system, which has passed at the next."""
    return lambda: at_each(root, lambda count: count == number and _fail(root, code), reading=True)


def _fail(root: Path, code: int) -> None:
    raise OSError(code, os.strerror(code), str(root))


def count(root: Path, path: Path, reading: bool = False) -> Callable[[], None]:
    """Write the number of operations so far to a file elsewhere."""
    return lambda: at_each(root, lambda number: path.write_text(str(number)), reading)


def no_file_beyond(root: Path, size: int) -> Callable[[], None]:
    """Let no file grow beyond a size [bytes]: writing fails half way, as on a full disk."""
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
