"""Tables and verdict of a verification.

A table has one row per gait: its velocity and the ``QUANTITIES``, NaN where one does not
apply.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from slider.core import tables
from slider.core.quantities import NONE, Quantity
from slider.core.tables import Table
from slider.robot.names import VELOCITY, velocity_text
from slider.verification.quantities import QUANTITIES

Bounds = Mapping[str, float | None]

_TEXT = Quantity("", digits=".3g").text


def judge(table: pd.DataFrame, bounds: Bounds) -> tuple[pd.DataFrame, list[str]]:
    """Add the column ``failed``, names of violated bounds; return also a line per violation.

    Lines are sorted by quantity.
    """
    failed, lines = [list[str]() for _ in range(len(table))], []
    gaits = [f"gait {velocity_text(velocity)}" for velocity in table[[*VELOCITY]].to_numpy()]
    for name, about in QUANTITIES.items():
        if (bound := bounds.get(name)) is None:
            continue
        values, expected = table[name].to_numpy(), f"expected {about.limit(bound)} {about.unit}"
        for row in np.flatnonzero(values < bound if about.at_least else values > bound):
            failed[row].append(name)
            lines.append(f"{gaits[row]}, {name}: {expected}, found {values[row]:.3g}")
    return table.assign(failed=[" ".join(names) for names in failed]), lines


def write_markdown(
    path: Path, table: pd.DataFrame, bounds: Bounds, failures: Sequence[str]
) -> None:
    """Write the verdict and the worst values by quantity, from the results of :func:`judge`."""
    failed, rows, bounded = set(" ".join(table["failed"]).split()), [], 0
    for name, about in QUANTITIES.items():
        values, bound = table[name].dropna(), bounds.get(name)
        if values.empty:
            continue
        worst = values.idxmin() if about.at_least else values.idxmax()
        vx, vy, yaw_rate = table.loc[worst, [*VELOCITY]]
        place = f"{vx:g}, {vy:g}" + (f", {yaw_rate:g} rad/s" if yaw_rate else "")
        limit = NONE if bound is None else about.limit(bound)
        limit += " **(not held)**" * (name in failed)
        bounded += bound is not None
        numbers = _TEXT(values[worst]), place, _TEXT(values.median())
        rows.append([str(about.check), f"`{name}`", about.unit, about.title, *numbers, limit])
    verdict = f"{len(failures)} values are beyond their bounds." if failures else "All bounds hold."
    head = ["check", "quantity", "unit", "meaning", "worst", "at vx, vy [m/s]", "median", "bound"]
    text = f"{len(table)} gaits, {bounded} bounds. **{verdict}**"
    path.write_text(tables.markdown([text, Table(head, rows)]), encoding="utf-8")
