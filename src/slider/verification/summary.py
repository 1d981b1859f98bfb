"""Tables, summary and verdict of a verification.

A table has one row per gait: its velocity and the ``QUANTITIES``, NaN where one does not
apply.
"""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from slider.core import tables
from slider.core.quantities import NONE
from slider.core.tables import Table
from slider.robot.names import VELOCITY, velocity_text
from slider.verification.quantities import QUANTITIES

Bounds = Mapping[str, float | None]


class Failure(NamedTuple):
    """A quantity of a gait that is beyond its bound, and one line about it."""

    velocity: tuple[float, ...]
    quantity: str
    text: str


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
            expected = f"expected {about.limit(bound)} {about.unit}"
            gait = f"gait {velocity_text(velocity)}, {name}"
            result.append(Failure(velocity, name, f"{gait}: {expected}, found {row[name]:.3g}"))
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
    return float(f"{value:.6g}") if math.isfinite(value) else None


def write_csv(path: Path, table: pd.DataFrame, failed: Sequence[Failure]) -> None:
    """One line per gait, one column per quantity, and the names of those that failed."""
    names: dict[tuple[float, ...], list[str]] = {}
    for failure in failed:
        names.setdefault(failure.velocity, []).append(failure.quantity)
    velocities = table[list(VELOCITY)].itertuples(index=False, name=None)
    table = table.assign(failed=[" ".join(names.get(velocity, [])) for velocity in velocities])
    tables.write(table, path)


_SHOWN_FAILURES = 20
_OVER_SPEED = "plant_force", "plant_torque", "plant_voltage", "dense_cop"
_HOLDS = {None: "", True: "", False: " **(not held)**"}


def write_markdown(
    path: Path, table: pd.DataFrame, quantities: Mapping[str, Any], failed: Sequence[Failure]
) -> None:
    """The verdict, worst values by quantity, and some over the speed straight ahead."""
    rows = []
    for name, row in quantities.items():
        about, bound = QUANTITIES[name], row["bound"]
        limit = NONE if bound is None else about.limit(bound)
        head = [str(about.check), f"`{name}`", about.unit, about.title]
        worst, median = (
            NONE if row[n] is None else about.text(row[n]) for n in ("worst", "median")
        )
        rows.append([*head, worst, place(row), median, limit + _HOLDS[row["passed"]]])
    head = ["check", "quantity", "unit", "meaning", "worst", "at vx, vy [m/s]", "median", "bound"]
    bounded = sum(row["bound"] is not None for row in quantities.values())
    verdict = f"{len(failed)} values are beyond their bounds:" if failed else "All bounds hold."
    lines = [f"* {failure.text}" for failure in failed[:_SHOWN_FAILURES]]
    if len(failed) > _SHOWN_FAILURES:
        lines.append(f"* {len(failed) - _SHOWN_FAILURES} more in `verification.csv`")
    parts: list[str | Table] = [
        f"{len(table)} gaits, {bounded} bounds. **{verdict}**",
        *["\n".join(lines)] * bool(lines),
    ]
    parts.append(Table(head, rows))
    straight = table[(table[list(VELOCITY[1:])] == 0).all(axis=1)]
    if len(straight):
        head = ["vx [m/s]", *(f"{speed:g}" for speed in straight[VELOCITY[0]])]
        rows = [[f"`{n}`", *map(QUANTITIES[n].text, straight[n])] for n in _OVER_SPEED]
        parts += ["Straight ahead:", Table(head, rows)]
    path.write_text(tables.markdown(parts), encoding="utf-8")


def place(row: Mapping[str, Any]) -> str:
    """Velocity of the gait that has the worst value of a quantity; a yaw rate if there is one."""
    turn = f", {row['yaw_rate']:g} rad/s" if row["yaw_rate"] else ""
    return f"{row['vx']:g}, {row['vy']:g}{turn}"
