"""What the independent checks of the gaits found: verdict, worst values, maps."""

import csv
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from slider.reports.page import Cell, Chart, Section, Table, chart
from slider.reports.sections.sources import Sources
from slider.reports.sections.velocity_map import velocity_map
from slider.verification.quantities import QUANTITIES

# What a gait is like, rather than whether its numbers are right; the first is drawn at first.
_MAPS = (
    "return_map",
    "regulated_steps",
    "replay_steps",
    "plant_force",
    "roll_end",
    "dense_torque",
    "dense_cop",
    "dense_friction",
    "jump_samples",
)
_HOLDS = {None: "–", True: "yes", False: "NO"}
_CAPTION = (
    "One square per gait; the menu above chooses the quantity, and the table below explains it. "
    "Above 1, the eigenvalue of the return map means that the gait, left alone in time, leaves "
    "its limit cycle, as a walk on line feet does."
)


def section(sources: Sources) -> Section:
    """The verdict, one row per quantity, and a map whose quantity can be chosen."""
    about = json.loads(sources.file("verification", "verification.json").read_text())
    values = {
        "gaits": about["gaits"],
        "failures": about["failures"],
        "bounded": sum(q["bound"] is not None for q in about["quantities"].values()),
        "charts": [_map(sources.file("verification", "verification.csv"))],
        "table": bounds_table(about["quantities"]),
    }
    return Section("Verification", "verification.html", values)


def bounds_table(quantities: Mapping[str, Mapping[str, Any]]) -> Table:
    """Worst value, bound, gait and median of each quantity of ``verification.json``."""
    columns = [
        "check",
        "quantity",
        "what it is",
        "unit",
        "worst",
        "bound",
        "holds",
        "at vx, vy [m/s]",
        "median",
    ]
    return Table(columns, [_row(name, found) for name, found in quantities.items()])


def _row(name: str, found: Mapping[str, Any]) -> list[Cell]:
    about, bound = QUANTITIES[name], found["bound"]
    sign = "≥" if about.at_least else "≤"
    return [
        Cell(str(about.check), about.check),
        Cell(name, name),
        Cell(about.meaning, about.meaning),
        Cell(_unit(name)),
        _number(found["worst"]),
        Cell("–") if bound is None else Cell(f"{sign} {bound:g}", bound),
        Cell(_HOLDS[found["passed"]], failed=found["passed"] is False),
        Cell(f"{found['vx']:g}, {found['vy']:g}", found["vx"]),
        _number(found["median"]),
    ]


def _unit(name: str) -> str:
    """Unit of a quantity; nothing for plain numbers."""
    unit = QUANTITIES[name].unit
    return "" if unit in ("-", "1") else unit


def _number(value: float | None) -> Cell:
    return Cell("not finite") if value is None else Cell(f"{value:.3g}", value)


def _map(path: Path) -> Chart:
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    velocities = np.array([[float(row["vx"]), float(row["vy"])] for row in rows])
    quantities = {
        f"{name} [{_unit(name) or '1'}]": np.array([float(row[name] or "nan") for row in rows])
        for name in _MAPS
    }
    return chart("verification-map", velocity_map(velocities, quantities), _CAPTION, height=360)
