"""Per-robot records of an evaluation: a table in a file, one row per robot."""

from dataclasses import asdict, fields
from pathlib import Path

import numpy as np

from slider.core.errors import UserError
from slider.env.metrics import GaitQuality, Tracking

Records = dict[str, np.ndarray]
FILE = "robots.csv"
QUALITY = tuple(item.name for item in fields(GaitQuality))
COLUMNS = (
    "trial",
    "robot",
    *(item.name for item in fields(Tracking)),
    *QUALITY,
    "diverged",
)


def build(
    trials: int, robots: int, tracked: Tracking, quality: GaitQuality, diverged: np.ndarray
) -> Records:
    """Columns of length trials · robots, robots of a trial next to each other."""
    return {
        "trial": np.repeat(np.arange(trials), robots),
        "robot": np.tile(np.arange(robots), trials),
        **asdict(tracked),
        **asdict(quality),
        "diverged": diverged,
    }


def write(records: Records, path: Path) -> None:
    """Write a CSV file; floating-point numbers keep 9 digits."""
    rows = [",".join(COLUMNS)]
    for values in zip(*(records[name] for name in COLUMNS), strict=True):
        rows.append(",".join(_text(value) for value in values))
    path.write_text("\n".join(rows) + "\n")


def read(path: Path) -> Records:
    """Read a CSV file back.

    Raises:
        UserError: the file has other columns.
    """
    header, *rows = path.read_text().splitlines()
    if tuple(header.split(",")) != COLUMNS:
        raise UserError(f"{path}: expected the columns {','.join(COLUMNS)}, found {header}")
    values = np.array([[float(x) for x in row.split(",")] for row in rows])
    records: Records = dict(zip(COLUMNS, values.T, strict=True))
    for name in ("survived", "tracked", "diverged"):
        records[name] = records[name].astype(bool)
    return records


def _text(value: np.generic) -> str:
    if isinstance(value, (np.bool_, np.integer)):
        return str(int(value))
    return f"{float(value):.9g}"
