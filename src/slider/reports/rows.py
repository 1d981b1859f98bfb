"""Rows of tables about evaluations: one per controller and command, means over robots."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np

from slider.core.job import Inputs
from slider.evaluation import records
from slider.library.contents import LibraryContents
from slider.library.sway import forward_variance
from slider.reports.controllers import OURS
from slider.reports.proportions import wilson

Row = dict[str, str | float]
Sway = Callable[[float], float | None]


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
    """Means over surviving robots of the gait's quality; empty where none survived."""
    row: Row = {"controller": controller, "command_velocity": command}
    for name in ("mean_velocity", *records.QUALITY):
        values = table[name][table["survived"]]
        row[name] = float(values.mean()) if len(values) else ""
    return row


def with_reference(quality: Row, sway: Sway) -> Row:
    """The gait's own velocity variance [m²/s²] beside the controller's; empty without a gait."""
    reference = sway(float(quality["command_velocity"]))
    row: Row = {}
    for name, value in quality.items():
        row[name] = value
        if name == "velocity_variance":
            row[f"reference_{name}"] = "" if reference is None else reference
    return row


def reference_sway(inputs: Inputs) -> Sway:
    """Forward velocity → variance within the gait of the input ``library``, if there is one."""
    if "library" not in inputs:
        return lambda command: None
    library = LibraryContents.load(inputs["library"][0] / "library.zarr")
    return lambda command: forward_variance(library, command)


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
