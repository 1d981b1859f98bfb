"""How a controller walks: a table per controller, quantities down, commands across."""

import csv
from collections.abc import Sequence
from pathlib import Path

from slider.reports.controllers import label, speed
from slider.reports.page import Cell, Table

_TITLES = {
    "mean_velocity": "mean velocity [m/s]",
    "flight": "flight, share of time",
    "double_support": "double support, share of time",
    "touchdown_rate": "touchdowns [1/s]",
    "reference_touchdown_rate": "touchdowns of the gait [1/s]",
    "alternation": "alternating steps, share of touchdowns",
    "clearance": "foot clearance [m]",
    "slip": "slip of loaded heels and toes [m/s]",
    "heading": "largest heading error, mean of the robots [rad]",
    "heading_worst": "largest heading error, worst robot [rad]",
    "asymmetry": "asymmetry of step times, share",
    "velocity_variance": "velocity ripple, variance [m²/s²]",
    "reference_velocity_variance": "velocity ripple of the gait [m²/s²]",
    "cost_of_transport": "cost of transport [1]",
    "peak_effort": "peak motor torque, worst robot, share of the limit",
    "peak_speed": "peak motor speed, worst robot, share of the limit",
    "leg_distance": "least distance of the legs, worst robot [m]",
    "legs_touch": "legs touch, share of time",
    "robots_touch": "legs ever touch, share of robots",
    "legs_cross": "feet cross, share of time",
    "robots_cross": "feet ever cross, share of robots",
}
_SMALLEST = 1e-4  # of any of these quantities that a reader cares about
_KEYS = ("controller", "command_velocity")


def quality_tables(path: Path) -> list[Table]:
    """Every column of ``gait_quality.csv`` as a row; empty where nobody survived."""
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    controllers = dict.fromkeys(row["controller"] for row in rows)
    return [_table(name, [r for r in rows if r["controller"] == name]) for name in controllers]


def _table(controller: str, rows: Sequence[dict[str, str]]) -> Table:
    """Rows of one controller, turned over: they hold different units, so nothing sorts."""
    commands = [speed(float(row["command_velocity"])) for row in rows]
    body = [
        [Cell(_TITLES.get(name, name)), *(_number(row[name]) for row in rows)]
        for name in rows[0]
        if name not in _KEYS
    ]
    heads = ["at a command of [m/s]", *commands]
    return Table(heads, body, label(controller), sortable=False)


def _number(text: str) -> Cell:
    if not text:
        return Cell("–")
    value = float(text)
    tiny = 0.0 < abs(value) < _SMALLEST
    return Cell(f"< {_SMALLEST:g}" if tiny else f"{value:.3g}", value)
