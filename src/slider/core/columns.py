"""Tables in CSV files: named columns of numbers, with 9 digits."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from slider.core.errors import UserError

Table = dict[str, np.ndarray]


def write(table: Table, columns: Iterable[str], path: Path) -> None:
    """Write some columns of a table."""
    names = tuple(columns)
    rows = [",".join(names)]
    for values in zip(*(table[name] for name in names), strict=True):
        rows.append(",".join(_text(value) for value in values))
    path.write_text("\n".join(rows) + "\n")


def read(path: Path, columns: Iterable[str], flags: Iterable[str]) -> Table:
    """Read a file back; columns ``flags`` are bool, the others float.

    Raises:
        UserError: the file has other columns.
    """
    names = tuple(columns)
    header, *rows = path.read_text().splitlines()
    if tuple(header.split(",")) != names:
        raise UserError(f"{path}: expected the columns {','.join(names)}, found {header}")
    values = np.array([[float(x) for x in row.split(",")] for row in rows])
    table: Table = dict(zip(names, values.T, strict=True))
    for name in flags:
        table[name] = table[name].astype(bool)
    return table


def _text(value: np.generic) -> str:
    if isinstance(value, (np.bool_, np.integer)):
        return str(int(value))
    return f"{float(value):.9g}"
