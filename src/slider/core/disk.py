"""Places that cannot be written, in one line: full or read-only disks, quotas, missing rights."""

import errno
import re
from collections.abc import Iterator
from pathlib import Path

from slider.core.errors import UserError

_READ_ONLY = (errno.EROFS, errno.EACCES, errno.EPERM)
_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
# What numpy and torch say of a full disk, without its number.
_SHORT = re.compile(
    r"requested and \d+ written|PytorchStreamWriter failed|inline_container.*unexpected pos"
)


def is_read_only(error: BaseException) -> bool:
    """Tell whether something may be read but not written."""
    return isinstance(error, OSError) and error.errno in _READ_ONLY


def not_written(error: BaseException, place: Path) -> UserError | None:
    """What to say if an error comes from a place that cannot be written, else nothing.

    ``place`` is named where the error names none.
    """
    for found in _chain(error):
        if isinstance(found, OSError) and found.errno in (*_READ_ONLY, *_FULL):
            where = found.filename2 or found.filename or place
            return UserError(f"expected to write {where}, found: {found.strerror}")
        if _SHORT.search(str(found)):
            return UserError(f"expected to write {place}, found: No space left on device")
    return None


def _chain(error: BaseException | None) -> Iterator[BaseException]:
    while error is not None:
        yield error
        error = error.__cause__ or error.__context__
