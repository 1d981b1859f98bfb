"""Columns of numbers in CSV files, with 9 digits."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from slider.core.errors import require

Columns = dict[str, np.ndarray]


def write(columns: Columns, path: Path) -> None:
    """Write columns of equal length; flags become 0 and 1."""
    rows = np.column_stack([*columns.values()])
    np.savetxt(path, rows, "%.9g", delimiter=",", header=",".join(columns), comments="")


def read(path: Path, expected: Iterable[str] = (), flags: Iterable[str] = ()) -> Columns:
    """Read a file back; columns ``flags`` are bool, the others float, empty cells NaN.

    Raises:
        UserError: the file has other columns than ``expected``, if any are.
    """
    names = tuple(expected)
    header, *rows = path.read_text(encoding="utf-8").splitlines()
    possible = not names or tuple(header.split(",")) == names
    require(possible, str(path), f"the columns {','.join(names)}", header)
    values = np.array([[float(text or "nan") for text in row.split(",")] for row in rows])
    columns: Columns = dict(zip(header.split(","), values.T, strict=True))
    return columns | {name: columns[name].astype(bool) for name in flags}
