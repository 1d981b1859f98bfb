"""Tables, summary and verdict of a verification.

A table has one row per gait: its velocity and the ``QUANTITIES``, NaN where one does not
apply.
"""

# The types of pandas' cells are unions of all that a cell may be.
# pyright: reportArgumentType=false

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from slider.robot.names import VELOCITY, velocity_text
from slider.verification.quantities import QUANTITIES, Quantity

Bounds = Mapping[str, float | None]
_DIGITS = "%.6g"


@dataclass(frozen=True)
class Failure:
    """A quantity of a gait that is beyond its bound."""

    velocity: tuple[float, ...]
    quantity: str
    value: float
    bound: float

    def __str__(self) -> str:
        about = QUANTITIES[self.quantity]
        return (
            f"gait {velocity_text(self.velocity)}, {self.quantity}: expected "
            f"{_limit(about, self.bound)} {about.unit}, found {self.value:.3g}"
        )


def _limit(about: Quantity, bound: float) -> str:
    return f"{'≥' if about.at_least else '≤'} {bound:g}"


def failures(table: pd.DataFrame, bounds: Bounds) -> list[Failure]:
    """Values beyond their bounds, by quantity."""
    result = []
    for name, about in QUANTITIES.items():
        bound = bounds.get(name)
        if bound is None:
            continue
        beyond = table[name] < bound if about.at_least else table[name] > bound
        for _, row in table[beyond].iterrows():
            velocity = tuple(float(row[axis]) for axis in VELOCITY)
            result.append(Failure(velocity, name, float(row[name]), bound))
    return result


def worst(table: pd.DataFrame, bounds: Bounds) -> dict[str, dict[str, Any]]:
    """Per quantity: its worst value and gait, median, bound and whether it holds."""
    failed = {failure.quantity for failure in failures(table, bounds)}
    result = {}
    for name, about in QUANTITIES.items():
        values = table[name].dropna()
        if values.empty:
            continue
        row = values.idxmin() if about.at_least else values.idxmax()
        result[name] = {
            "check": about.check,
            "unit": about.unit,
            "worst": _number(float(values[row])),
            **{axis: float(table[axis][row]) for axis in VELOCITY},
            "median": _number(float(values.median())),
            "bound": bounds.get(name),
            "passed": None if bounds.get(name) is None else name not in failed,
        }
    return result


def _number(value: float) -> float | None:
    """JSON has neither infinity nor NaN."""
    return float(_DIGITS % value) if math.isfinite(value) else None


def write_csv(path: Path, table: pd.DataFrame, failed: Sequence[Failure]) -> None:
    """One line per gait, one column per quantity, and the names of those that failed."""
    names: dict[tuple[float, ...], list[str]] = {}
    for failure in failed:
        names.setdefault(failure.velocity, []).append(failure.quantity)
    velocities = table[list(VELOCITY)].itertuples(index=False, name=None)
    table = table.assign(failed=[" ".join(names.get(velocity, [])) for velocity in velocities])
    table.to_csv(path, index=False, float_format=_DIGITS, lineterminator="\n")


# Quantities of the second table of the report, over the speed.
_OVER_SPEED = (
    *("plant_force", "plant_torque", "plant_voltage", "dense_cop"),
    *("regulated_steps", "regulated_speed"),
)
_HOLDS = {None: "", True: "", False: " **(not held)**"}


def write_markdown(path: Path, table: pd.DataFrame, quantities: Mapping[str, Any]) -> None:
    """Worst values by quantity, and some over the speed straight ahead."""
    head = ["check", "quantity", "unit", "meaning", "worst", "at vx, vy [m/s]", "median", "bound"]
    lines = _grid(head, [_cells(name, row) for name, row in quantities.items()])
    straight = table[(table[list(VELOCITY[1:])] == 0).all(axis=1)]
    if len(straight):
        head = ["vx [m/s]", *(f"{speed:g}" for speed in straight[VELOCITY[0]])]
        rows = [[f"`{name}`", *map(_short, straight[name])] for name in _OVER_SPEED]
        lines += ["", "Straight ahead:", "", *_grid(head, rows)]
    path.write_text(f"{len(table)} gaits.\n\n" + "\n".join(lines) + "\n", encoding="utf-8")


def _cells(name: str, row: Mapping[str, Any]) -> list[str]:
    about, bound = QUANTITIES[name], row["bound"]
    limit = "–" if bound is None else _limit(about, bound)
    values = [_short(row["worst"]), place(row), _short(row["median"])]
    head = [str(about.check), f"`{name}`", about.unit, about.meaning]
    return [*head, *values, limit + _HOLDS[row["passed"]]]


def place(row: Mapping[str, Any]) -> str:
    """Velocity of the gait that has the worst value of a quantity; a yaw rate if there is one."""
    turn = f", {row['yaw_rate']:g} rad/s" if row["yaw_rate"] else ""
    return f"{row['vx']:g}, {row['vy']:g}{turn}"


def _short(value: float | None) -> str:
    return "–" if value is None or math.isnan(value) else f"{value:.3g}"


def _grid(head: Sequence[str], body: Sequence[Sequence[str]]) -> list[str]:
    return [f"| {' | '.join(cells)} |" for cells in (head, ["---"] * len(head), *body)]
