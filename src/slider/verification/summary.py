"""Tables, summary and verdict of a verification."""

import csv
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from slider.core.errors import UserError
from slider.robot.names import COMMAND, command_text
from slider.verification.neighbours import Pair
from slider.verification.quantities import QUANTITIES, Quantity

Bounds = dict[str, float | None]


@dataclass(frozen=True)
class Row:
    """Quantities of the gait of a command; some do not exist for every gait."""

    command: tuple[float, ...]
    values: dict[str, float]


@dataclass(frozen=True)
class Failure:
    """A quantity of a gait that is beyond its bound."""

    command: tuple[float, ...]
    quantity: str
    value: float
    bound: float

    def __str__(self) -> str:
        about = QUANTITIES[self.quantity]
        sign = "≥" if about.at_least else "≤"
        return (
            f"gait {command_text(self.command)}, {self.quantity}: expected {sign} {self.bound:g} "
            f"{about.unit}, found {self.value:.3g}"
        )


def check_names(bounds: Bounds) -> None:
    """Refuse bounds that do not belong to the quantities.

    Raises:
        UserError: names what is unknown or missing.
    """
    unknown = sorted(set(bounds) - set(QUANTITIES))
    missing = sorted(set(QUANTITIES) - set(bounds))
    if unknown or missing:
        what = f"unknown {', '.join(unknown)}" if unknown else f"none for {', '.join(missing)}"
        raise UserError(
            f"verification.bounds: expected one bound (or null) per quantity, found {what}"
        )


def failures(rows: Sequence[Row], bounds: Bounds) -> list[Failure]:
    """Values beyond their bounds, by quantity; a value that is no number fails too."""
    found = []
    for name, about in QUANTITIES.items():
        bound = bounds[name]
        if bound is None:
            continue
        for row in rows:
            value = row.values.get(name)
            if value is not None and not _holds(value, bound, about):
                found.append(Failure(row.command, name, value, bound))
    return found


def _holds(value: float, bound: float, about: Quantity) -> bool:
    return value >= bound if about.at_least else value <= bound


def worst(rows: Sequence[Row], bounds: Bounds) -> dict[str, dict[str, Any]]:
    """Per quantity: its worst value and gait, median, bound and whether it holds."""
    failed = {failure.quantity for failure in failures(rows, bounds)}
    table = {}
    for name, about in QUANTITIES.items():
        having = [row for row in rows if name in row.values]
        if not having:
            continue
        row = max(having, key=lambda row: _badness(row.values[name], about))
        table[name] = {
            "check": about.check,
            "unit": about.unit,
            "worst": _number(row.values[name]),
            **dict(zip(COMMAND, row.command, strict=True)),
            "median": _number(float(np.median([row.values[name] for row in having]))),
            "bound": bounds[name],
            "passed": None if bounds[name] is None else name not in failed,
        }
    return table


def _badness(value: float, about: Quantity) -> float:
    if math.isnan(value):
        return math.inf
    return -value if about.at_least else value


def _number(value: float) -> float | None:
    """JSON has neither infinity nor NaN."""
    return float(f"{value:.6g}") if math.isfinite(value) else None


def describe_pairs(
    pairs: Sequence[Pair], rows: Sequence[Row], bounds: Bounds
) -> list[dict[str, Any]]:
    """Neighbours whose jump is beyond a bound."""
    found = []
    for pair in pairs:
        jumps = {"jump_samples": pair.samples, "jump_coefficients": pair.coefficients}
        limits = {name: bounds[name] for name in jumps}
        if any(limit is not None and jumps[name] > limit for name, limit in limits.items()):
            ends = {"from": rows[pair.first].command, "to": rows[pair.second].command}
            found.append(ends | {name: _number(value) for name, value in jumps.items()})
    return found


def write_csv(path: Path, rows: Sequence[Row], failed: Sequence[Failure]) -> None:
    """One line per gait, one column per quantity, and the names of those that failed."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([*COMMAND, *QUANTITIES, "failed"])
        for row in rows:
            names = [f.quantity for f in failed if f.command == row.command]
            values = [_text(row.values.get(name)) for name in QUANTITIES]
            writer.writerow([*(f"{v:g}" for v in row.command), *values, " ".join(names)])


def _text(value: float | None) -> str:
    return "" if value is None else f"{value:.6g}"


def write_json(path: Path, content: dict[str, Any]) -> None:
    """The summary that programmes read."""
    path.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n")


# What the second table of the report for people follows over the forward velocity.
_OVER_SPEED = (
    "plant_force",
    "plant_torque",
    "plant_voltage",
    "dense_cop",
    "return_map",
    "replay_steps",
    "regulated_steps",
    "regulated_speed",
)
_HOLDS = {None: "", True: "", False: " **(not held)**"}


def write_markdown(path: Path, rows: Sequence[Row], table: dict[str, dict[str, Any]]) -> None:
    """Worst values by quantity, and some over the forward velocity straight ahead."""
    head = ["check", "quantity", "unit", "meaning", "worst", "at vx, vy [m/s]", "median", "bound"]
    lines = _grid(head, [_cells(name, found) for name, found in table.items()])
    straight = [row for row in rows if not any(row.command[1:])]
    if straight:
        head = ["vx [m/s]", *(f"{row.command[0]:g}" for row in straight)]
        over = [
            [f"`{name}`", *(_short(row.values.get(name)) for row in straight)]
            for name in _OVER_SPEED
        ]
        lines += ["", "Straight ahead:", "", *_grid(head, over)]
    path.write_text(f"{len(rows)} gaits.\n\n" + "\n".join(lines) + "\n")


def _cells(name: str, found: dict[str, Any]) -> list[str]:
    about, bound = QUANTITIES[name], found["bound"]
    limit = "–" if bound is None else f"{'≥' if about.at_least else '≤'} {bound:g}"
    return [
        str(about.check),
        f"`{name}`",
        about.unit,
        about.meaning,
        _short(found["worst"]),
        place(found),
        _short(found["median"]),
        limit + _HOLDS[found["passed"]],
    ]


def place(found: Mapping[str, Any]) -> str:
    """Command of the gait that has the worst value of a quantity; a yaw rate if there is one."""
    turn = f", {found['yaw_rate']:g} rad/s" if found["yaw_rate"] else ""
    return f"{found['vx']:g}, {found['vy']:g}{turn}"


def _short(value: float | None) -> str:
    return "–" if value is None else f"{value:.3g}"


def _grid(head: Sequence[str], body: Sequence[Sequence[str]]) -> list[str]:
    return [f"| {' | '.join(cells)} |" for cells in (head, ["---"] * len(head), *body)]
