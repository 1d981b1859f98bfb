"""Quantities of the gaits' stability: columns of the CSV file, and the report in Markdown."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from slider.core.tables import Table
from slider.robot.names import VELOCITY

Values = Mapping[str, Any]
CSV, MARKDOWN = "stability.csv", "stability.md"


QUANTITIES: dict[str, tuple[str, str]] = {
    "phase": ("-", "hip or time"),
    "spectral_radius": ("1/step", "of the return map, without foot placement"),
    "eigenvalues": ("1/step", "moduli of its multipliers that are not zero"),
    "closed_eigenvalues": ("1/step", "the same with foot placement"),
    "closed_spectral_radius": ("1/step", "the greatest of these"),
    "gain_position": (
        "-",
        "displacement of the right foot to the left per lateral position, at the start",
    ),
    "gain_lateral": ("s", "the same per lateral velocity"),
    "gain_forward": ("s", "its displacement forward per forward velocity"),
    "hip_share": ("-", "least forward velocity of the hip, share of its mean"),
    "decoupling": ("rad/s², m/s²", "least singular value of the decoupling matrix"),
    "condition": ("-", "its greatest condition number"),
}
"""Unit and meaning of each column."""
_OVER_SPEED = (
    *("spectral_radius", "closed_spectral_radius", "gain_position", "gain_lateral", "gain_forward"),
    *("hip_share", "decoupling"),
)


def write_csv(path: Path, rows: Sequence[Values]) -> None:
    """One line per gait; several values of one column are separated by blanks."""
    columns = [*VELOCITY, *QUANTITIES]
    table = pd.DataFrame([[_text(row.get(n), 6) for n in columns] for row in rows], columns=columns)
    table.to_csv(path, index=False, lineterminator="\n")


def write_markdown(path: Path, rows: Sequence[Values]) -> None:
    """Range of each quantity over the gaits, and some over the forward velocity at vy = 0."""
    lines = [f"{len(rows)} gaits.", ""]
    head = ["quantity", "unit", "meaning", "least", "median", "greatest"]
    ranges = [_range(name, rows) for name in QUANTITIES if name != "phase"]
    lines.append(Table(head, ranges).markdown)
    straight = [row for row in rows if row["vy"] == row["yaw_rate"] == 0.0]
    if straight:
        head = ["vx [m/s]", *(f"{row['vx']:g}" for row in straight)]
        body = [[f"`{n}`", *(_text(row.get(n), 3) for row in straight)] for n in _OVER_SPEED]
        lines += ["", "At vy = 0:", "", Table(head, body).markdown]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _range(name: str, rows: Sequence[Values]) -> list[str]:
    values = [np.max(row[name]) for row in rows if row.get(name) is not None]
    numbers = [f"{f(values):.3g}" for f in (np.min, np.median, np.max)] if values else ["–"] * 3
    return [f"`{name}`", *QUANTITIES[name], *numbers]


def _text(value: Any, digits: int) -> str:
    if value is None or isinstance(value, str):
        return value or ""
    return " ".join(f"{number:.{digits}g}" for number in np.atleast_1d(value))
