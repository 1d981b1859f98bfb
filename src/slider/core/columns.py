"""Columns of numbers in CSV files, with 9 digits."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from slider.core.errors import UserError

Columns = dict[str, np.ndarray]


def write(columns: Columns, path: Path) -> None:
    """Write columns of equal length; flags become 0 and 1."""
    rows = [",".join(columns)]
    rows += [",".join(map(_text, values)) for values in zip(*columns.values(), strict=True)]
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")


def read(path: Path, expected: Iterable[str] = (), flags: Iterable[str] = ()) -> Columns:
    """Read a file back; columns ``flags`` are bool, the others float, empty cells NaN.

    Raises:
        UserError: the file has other columns than ``expected``, if any are.
    """
    names = tuple(expected)
    header, *rows = path.read_text(encoding="utf-8").splitlines()
    if names and tuple(header.split(",")) != names:
        raise UserError(f"{path}: expected the columns {','.join(names)}, found {header}")
    values = np.array([[float(text or "nan") for text in row.split(",")] for row in rows])
    columns: Columns = dict(zip(header.split(","), values.T, strict=True))
    return columns | {name: columns[name].astype(bool) for name in flags}


def _text(value: np.generic) -> str:
    if isinstance(value, (np.bool_, np.integer)):
        return str(int(value))
    return f"{float(value):.9g}"
