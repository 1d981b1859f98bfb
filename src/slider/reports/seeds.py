"""Numbers of several seeds: their mean and range."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

Row = Mapping[str, str | float]


@dataclass(frozen=True)
class Spread:
    """Mean, least and greatest of a number over seeds; ``count`` seeds have it."""

    mean: float
    lower: float
    upper: float
    count: int


def spread(values: Sequence[float]) -> Spread | None:
    """Of the numbers there are (NaN is none), or nothing where there is none."""
    known = np.array([value for value in values if not np.isnan(value)])
    if not len(known):
        return None
    return Spread(float(known.mean()), float(known.min()), float(known.max()), len(known))


def numbers(rows: Sequence[Row], name: str, **where: str | float) -> list[float]:
    """A column of the rows that have these values; an empty cell is NaN."""
    chosen = [row for row in rows if all(row[key] == value for key, value in where.items())]
    return [float("nan") if row[name] == "" else float(row[name]) for row in chosen]


def distinct(rows: Sequence[Row], name: str) -> list[float]:
    """Different numbers of a column, ascending."""
    return sorted({float(row[name]) for row in rows})
