"""Per-robot records of an evaluation: a table in a file, one row per robot."""

from dataclasses import asdict, fields
from pathlib import Path

import numpy as np

from slider.env.metrics import GaitQuality, Tracking
from slider.evaluation import table_file

Records = table_file.Table
FILE = "robots.csv"
QUALITY = tuple(item.name for item in fields(GaitQuality))
COLUMNS = (
    "trial",
    "robot",
    *(item.name for item in fields(Tracking)),
    *QUALITY,
    "diverged",
)
FLAGS = ("survived", "tracked", "diverged")


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
    table_file.write(records, COLUMNS, path)


def read(path: Path) -> Records:
    """Read a CSV file back.

    Raises:
        UserError: the file has other columns.
    """
    return table_file.read(path, COLUMNS, FLAGS)
