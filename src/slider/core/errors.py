"""Errors that users see as a single line."""

import errno
import os
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any


class UserError(Exception):
    """Bad input from a user: one line that says what was expected and what was found.

    Command-line entry points print it without a traceback and exit with status 1.
    """


class NotReadError(UserError):
    """A file could not be read, which does not mean that its content is damaged."""


def not_read(error: OSError, place: Path) -> NotReadError:
    """Error about a path that cannot be read; ``place`` is named if the error names no path."""
    return NotReadError(
        f"expected to read {error.filename or place}, found: {error.strerror or error}"
    )


def require(condition: bool, key: str, expected: str, found: Any) -> None:
    """Raise a ``UserError`` about the value of a key unless a condition holds."""
    if not condition:
        raise UserError(f"{key}: expected {expected}, found {found}")


def one_of(key: str, value: Any, allowed: Iterable[Any]) -> None:
    """Raise a ``UserError`` unless the value of a key is a member of ``allowed``."""
    options = tuple(allowed)
    require(value in options, key, f"one of {', '.join(map(str, options))}", value)


_OF_DISKS = (errno.EROFS, errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_FOLDERS = ("reports", ".snakemake")
# Messages of numpy and torch about a full disk, which lack the error number.
_SHORT = re.compile(
    r"requested and \d+ written|PytorchStreamWriter failed|inline_container.*unexpected pos"
)

# Messages of torch, CasADi, MuJoCo and CUDA instead of a MemoryError.
_NO_MEMORY = re.compile(r"(can't|not) allocate memory|bad_alloc|out of memory", re.IGNORECASE)


def not_written(error: BaseException, place: Path) -> UserError | None:
    """Error about a path that cannot be written; None if ``error`` has another cause.

    ``place`` is named if the error names no path. Errors other than those of disks, such as a
    missing permission, count only below ``place`` and other folders that the pipeline writes.
    """
    for cause in _chain(error):
        if isinstance(cause, OSError):
            where = cause.filename2 or cause.filename
            refused = cause.errno != errno.ENOENT and _is_ours(where, place)
            if refused or cause.errno in _OF_DISKS:
                return UserError(f"expected to write {where or place}, found: {cause.strerror}")
        if _SHORT.search(str(cause)):
            return UserError(f"expected to write {place}, found: No space left on device")
    return None


def no_memory(error: BaseException) -> UserError | None:
    """Error about a failed memory allocation; None if ``error`` has another cause."""
    for cause in _chain(error):
        if isinstance(cause, MemoryError) or _NO_MEMORY.search(str(cause)):
            found = next(iter(str(cause).splitlines()), "") or "none"
            return UserError(
                f"expected more memory, found: {found}; results and checkpoints are kept, "
                "the same command again goes on from there"
            )
    return None


def _is_ours(where: object, place: Path) -> bool:
    if not isinstance(where, str | os.PathLike):
        return False
    folders = (Path(folder).resolve() for folder in (place, *_FOLDERS))  # the store may be a link
    return any(map(Path(where).resolve().is_relative_to, folders))


def _chain(error: BaseException | None) -> Iterator[BaseException]:
    """An error and its causes; for an ``OSError`` also its context."""
    while error is not None:
        yield error
        handled = isinstance(error, OSError) and not error.__suppress_context__
        error = error.__cause__ or (error.__context__ if handled else None)
