"""Quantities of the gaits' stability: columns of the CSV file, and the report in Markdown."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from slider.core import tables
from slider.core.quantities import NONE, Quantity
from slider.core.tables import Table

CSV, MARKDOWN = "stability.csv", "stability.md"


QUANTITIES: dict[str, Quantity] = {
    "phase": Quantity("hip or time", "-"),
    "spectral_radius": Quantity("of the return map, without foot placement", "1/step"),
    "eigenvalues": Quantity("moduli of its multipliers that are not zero", "1/step"),
    "closed_eigenvalues": Quantity("the same with foot placement", "1/step"),
    "closed_spectral_radius": Quantity("the greatest of these", "1/step"),
    "gain_position": Quantity(
        "displacement of the right foot to the left per lateral position, at the start", "-"
    ),
    "gain_lateral": Quantity("the same per lateral velocity", "s"),
    "gain_forward": Quantity("its displacement forward per forward velocity", "s"),
    "hip_share": Quantity("least forward velocity of the hip, share of its mean", "-"),
    "decoupling": Quantity("least singular value of the decoupling matrix", "rad/s², m/s²"),
    "condition": Quantity("its greatest condition number", "-"),
}
"""Unit and meaning of each column."""
_OVER_SPEED = (
    *("spectral_radius", "closed_spectral_radius", "gain_position", "gain_lateral", "gain_forward"),
    *("hip_share", "decoupling"),
)


def write_csv(path: Path, frame: pd.DataFrame) -> None:
    """One line per gait; several values of one column are separated by blanks."""
    several = [name for name in frame if name.endswith("eigenvalues")]
    texts = {name: [_text(values, 6) for values in frame[name]] for name in several}
    tables.write(frame.assign(**texts), path)


def write_markdown(path: Path, frame: pd.DataFrame) -> None:
    """Range of each quantity over the gaits, and some over the forward velocity at vy = 0."""
    head = ["quantity", "unit", "meaning", "least", "median", "greatest"]
    ranges = [_range(name, frame[name]) for name in QUANTITIES if name != "phase"]
    parts = [f"{len(frame)} gaits.", Table(head, ranges)]
    straight = frame[(frame["vy"] == 0) & (frame["yaw_rate"] == 0)]
    if len(straight):
        head = ["vx [m/s]", *(f"{speed:g}" for speed in straight["vx"])]
        body = [[f"`{n}`", *(_text(value, 3) for value in straight[n])] for n in _OVER_SPEED]
        parts += ["At vy = 0:", Table(head, body)]
    path.write_text(tables.markdown(parts), encoding="utf-8")


def _range(name: str, column: pd.Series) -> list[str]:
    values = column.dropna().map(np.max)
    numbers = (values.min(), values.median(), values.max())
    texts = [f"{number:.3g}" for number in numbers] if len(values) else [NONE] * 3
    return [f"`{name}`", QUANTITIES[name].unit, QUANTITIES[name].title, *texts]


def _text(value: Any, digits: int) -> str:
    """One number, or several; empty for NaN."""
    return " ".join(f"{number:.{digits}g}" for number in np.atleast_1d(value) if number == number)
