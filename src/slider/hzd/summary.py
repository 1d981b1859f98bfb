"""What is known of a gait's stability: quantities, their table, and the table for people."""

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from slider.robot.names import VELOCITY

Values = Mapping[str, Any]
CSV, MARKDOWN = "stability.csv", "stability.md"


class Quantity(NamedTuple):
    """A column.

    Attributes:
        unit: of its values.
        meaning: in the table for people.
    """

    unit: str
    meaning: str


QUANTITIES = {
    "phase": Quantity("-", "hip or time"),
    "spectral_radius": Quantity("1/step", "of the full return map, without foot placement"),
    "eigenvalues": Quantity("1/step", "moduli of the restricted map's, without foot placement"),
    "closed_eigenvalues": Quantity("1/step", "the same with it"),
    "closed_spectral_radius": Quantity("1/step", "of the full return map with it"),
    "gain_position": Quantity(
        "-", "displacement of the right foot to the left per lateral position, at the start"
    ),
    "gain_lateral": Quantity("s", "the same per lateral velocity"),
    "gain_forward": Quantity("s", "its displacement forward per forward velocity"),
    "difference": Quantity("-", "change of the derivatives with twice the difference"),
    "invariance_orbit": Quantity("rad, m, 1/s", "‖(y, ẏ)‖ on the limit cycle"),
    "invariance_impact": Quantity("rad, m, 1/s", "after perturbed impacts, not re-anchored"),
    "invariance_free": Quantity("rad, m, 1/s", "at the end of the step after, not re-anchored"),
    "invariance_anchored": Quantity("rad, m, 1/s", "at the end of the step after, re-anchored"),
    "settle_angle": Quantity("rad", "by which the ankle lays a foot flat after these impacts"),
    "hip_share": Quantity("-", "least forward velocity of the hip, share of its mean"),
    "decoupling": Quantity("rad/s², m/s²", "least singular value of the decoupling matrix"),
    "condition": Quantity("-", "its greatest condition number"),
}
_OVER_SPEED = (
    "spectral_radius",
    "closed_spectral_radius",
    "gain_position",
    "gain_lateral",
    "gain_forward",
    "invariance_impact",
    "invariance_free",
    "invariance_anchored",
    "hip_share",
    "decoupling",
)


def per_step(eigenvalues: np.ndarray) -> list[float]:
    """Moduli of a walk's eigenvalues, per step: a walk has two. Greatest first."""
    return sorted(np.sqrt(np.abs(eigenvalues)).tolist(), reverse=True)


def write_csv(path: Path, rows: Sequence[Values]) -> None:
    """One line per gait; several values of one column are separated by blanks."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([*VELOCITY, *QUANTITIES])
        for row in rows:
            writer.writerow([_text(row.get(name), 6) for name in (*VELOCITY, *QUANTITIES)])


def write_markdown(path: Path, rows: Sequence[Values]) -> None:
    """Range of each quantity over the gaits, and some over the forward velocity at vy = 0."""
    lines = [f"{len(rows)} gaits.", ""]
    head = ["quantity", "unit", "meaning", "least", "median", "greatest"]
    lines += _grid(head, [_range(name, rows) for name in QUANTITIES if name != "phase"])
    straight = [row for row in rows if row["vy"] == row["yaw_rate"] == 0.0]
    if straight:
        head = ["vx [m/s]", *(f"{row['vx']:g}" for row in straight)]
        body = [[f"`{n}`", *(_text(row.get(n), 3) for row in straight)] for n in _OVER_SPEED]
        lines += ["", "At vy = 0:", "", *_grid(head, body)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _range(name: str, rows: Sequence[Values]) -> list[str]:
    about = QUANTITIES[name]
    found = [np.max(row[name]) for row in rows if row.get(name) is not None]
    numbers = [f"{f(found):.3g}" for f in (np.min, np.median, np.max)] if found else ["–"] * 3
    return [f"`{name}`", about.unit, about.meaning, *numbers]


def _text(value: Any, digits: int) -> str:
    if value is None or isinstance(value, str):
        return value or ""
    return " ".join(f"{number:.{digits}g}" for number in np.atleast_1d(value))


def _grid(head: Sequence[str], body: Sequence[Sequence[str]]) -> list[str]:
    return [f"| {' | '.join(cells)} |" for cells in (head, ["---"] * len(head), *body)]
