"""Rows of tables about evaluations: one per controller and command, means over robots."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np

from slider.core.job import Inputs
from slider.evaluation import records
from slider.library.gait_numbers import GaitNumbers, gait_numbers
from slider.library.reader import GaitLibrary
from slider.reports.controllers import OURS
from slider.reports.proportions import wilson

Row = dict[str, str | float]
Reference = Callable[[float], GaitNumbers | None]


def table_row(controller: str, command: float, table: records.Records) -> Row:
    """Means over all robots; spreads are standard deviations over trials.

    Errors are means over surviving robots, ``inf`` where none survived, as in the paper.
    """
    survived, trial = table["survived"], table["trial"]
    row: Row = {"controller": controller, "source": OURS, "command_velocity": command}
    row |= success(survived, trial)
    tracked = table["tracked"].astype(float)
    row |= {"tracking_rate": float(tracked.mean()), "tracking_rate_std": spread(tracked, trial)}
    for name, column in (("mse", "squared_error"), ("mse_steady", "squared_error_steady")):
        values = table[column][survived]
        row[name] = float(values.mean()) if len(values) else float("inf")
        row[f"{name}_std"] = spread(values, trial[survived])
    return row


def success(survived: np.ndarray, trial: np.ndarray) -> Row:
    """Share of robots (N,) that survived, its spread over trials, and Wilson's 95 % interval."""
    low, high = wilson(int(survived.sum()), len(survived))
    return {
        "success_rate": float(survived.mean()),
        "success_rate_std": spread(survived.astype(float), trial),
        "success_low": low,
        "success_high": high,
    }


def quality_row(controller: str, command: float, table: records.Records) -> Row:
    """How the robots that survive walk; empty where none survived.

    Means over robots, but for extremes, which are those of all robots: ``peak_effort``,
    ``peak_speed`` (largest) and ``leg_distance`` (least). ``heading`` is the mean of the robots'
    largest errors, ``heading_worst`` the largest of all. ``robots_touch`` and ``robots_cross`` are
    the shares of robots whose legs ever touch or cross.
    """
    row: Row = {"controller": controller, "command_velocity": command}
    for name in ("mean_velocity", *records.QUALITY):
        values = table[name][table["survived"]]
        for column, number in _COLUMNS.get(name, {name: np.mean}).items():
            row[column] = float(number(values)) if len(values) else ""
    return row


def _ever(shares: np.ndarray) -> float:
    """Share of robots with some of what these are shares of time of."""
    return float(np.mean(shares > 0))


# Quantity of a robot → columns, and how its values over robots become their number.
_COLUMNS: dict[str, dict[str, Callable[[np.ndarray], float]]] = {
    "heading": {"heading": np.mean, "heading_worst": np.max},
    "peak_effort": {"peak_effort": np.max},
    "peak_speed": {"peak_speed": np.max},
    "leg_distance": {"leg_distance": np.min},
    "legs_touch": {"legs_touch": np.mean, "robots_touch": _ever},
    "legs_cross": {"legs_cross": np.mean, "robots_cross": _ever},
}


def with_reference(quality: Row, reference: Reference) -> Row:
    """The gait's own numbers beside the controller's, as ``reference_NAME``; empty without one."""
    gait = reference(float(quality["command_velocity"]))
    row: Row = {}
    for name, value in quality.items():
        row[name] = value
        if name in GaitNumbers._fields:
            row[f"reference_{name}"] = "" if gait is None else getattr(gait, name)
    return row


def reference_gaits(inputs: Inputs) -> Reference:
    """Forward velocity → numbers of the gait of the input ``library``, if there is one."""
    if "library" not in inputs:
        return lambda command: None
    library = GaitLibrary.load(inputs["library"][0] / "library.zarr")
    return lambda command: gait_numbers(library, command)


def read_evaluation(folder: Path) -> tuple[str, float, records.Records]:
    """Controller, command [m/s] and records of an evaluation at a constant command."""
    about = json.loads((folder / "command.json").read_text())
    return about["controller"], about["command"], records.read(folder / records.FILE)


def spread(values: np.ndarray, trial: np.ndarray) -> float | str:
    """Standard deviation over trials of the trial means; empty for fewer than two trials."""
    means = [values[trial == t].mean() for t in np.unique(trial)]
    return float(np.std(means, ddof=1)) if len(means) > 1 else ""


def write_rows(rows: list[Row], columns: tuple[str, ...], path: Path) -> None:
    """Write some columns of rows as CSV; numbers keep 6 digits."""
    lines = [",".join(columns)]
    lines += [",".join(_text(row[name]) for name in columns) for row in rows]
    path.write_text("\n".join(lines) + "\n")


def _text(value: str | float) -> str:
    return value if isinstance(value, str) else f"{value:.6g}"
