"""The one error that users see as a single line."""

import errno
from collections.abc import Iterable
from pathlib import Path
from typing import Any


class UserError(Exception):
    """Bad input from a user: one line that says what was expected and what was found.

    Command-line entry points print it without a trace and exit with status 1.
    """


def require(condition: bool, key: str, expected: str, found: Any) -> None:
    """Raise a ``UserError`` about the value of a key unless a condition holds."""
    if not condition:
        raise UserError(f"{key}: expected {expected}, found {found}")


def one_of(key: str, value: Any, allowed: Iterable[Any]) -> None:
    """Raise a ``UserError`` unless the value of a key is a member of ``allowed``."""
    options = tuple(allowed)
    require(value in options, key, f"one of {', '.join(map(str, options))}", value)


_OF_DISKS = (
    *(errno.EROFS, errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EACCES, errno.EPERM),
    *(errno.EIO, errno.EMFILE, errno.ENFILE, errno.ESTALE),
)


def is_of_disks(error: BaseException) -> bool:
    """Tell whether a disk is full, read-only or at fault, or a right or descriptor lacks."""
    return isinstance(error, OSError) and error.errno in _OF_DISKS


def file_line(error: OSError, place: Path) -> str:
    """Line about a file that cannot be read or written; ``place`` where the error names none."""
    return f"{error.filename2 or error.filename or place}: {error.strerror or error}"
