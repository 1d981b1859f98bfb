"""The stage ``table1``: ours beside the paper's, one row per controller and command."""

import csv
import json
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path

import numpy as np

from slider.core.job import Inputs, Job, Section, Summary
from slider.evaluation import records
from slider.library.contents import LibraryContents
from slider.library.sway import forward_variance
from slider.reports import table1_text
from slider.reports.comparison import read_rows

COLUMNS = (
    "controller",
    "source",
    "command_velocity",
    "success_rate",
    "success_rate_std",
    "mse",
    "mse_std",
    "mse_steady",
    "mse_steady_std",
    "tracking_rate",
    "tracking_rate_std",
)
OURS, PAPER = "measured", "paper"
_PAPER_TABLE = "paper_table1.csv"

Row = dict[str, str | float]


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write Table 1 as CSV, Markdown and LaTeX, and a table about the quality of the gait."""
    evaluations = [read_evaluation(folder) for folder in inputs["evaluations"]]
    rows = [table_row(*evaluation) for evaluation in evaluations]
    write_table(rows + paper_rows(), COLUMNS, out / "table1.csv")
    sway = reference_sway(inputs)
    quality = [quality_row(*evaluation, sway(evaluation[1])) for evaluation in evaluations]
    write_table(quality, tuple(quality[0]), out / "gait_quality.csv")
    comparable = read_rows(out / "table1.csv")
    (out / "table1.md").write_text(table1_text.markdown(comparable), encoding="utf-8")
    (out / "table1.tex").write_text(table1_text.latex(comparable), encoding="utf-8")
    job.tracker.log_file(out / "table1.csv")
    job.tracker.log_metrics(_metrics(rows), 0)
    return {"rows": len(rows)}


def _metrics(rows: list[Row]) -> dict[str, float]:
    """The whole table as metrics of one run, such as ``success_rate/policy/1.2``."""
    names = ("success_rate", "mse", "mse_steady", "tracking_rate")
    found = {
        f"{name}/{row['controller']}/{row['command_velocity']}": float(row[name])
        for row in rows
        for name in names
    }
    return {name: value for name, value in found.items() if np.isfinite(value)}


def table_row(controller: str, command: float, table: records.Records) -> Row:
    """Means over all robots; spreads are standard deviations over trials.

    Errors are means over surviving robots, ``inf`` where none survived, as in the paper.
    """
    survived, trial = table["survived"], table["trial"]
    row: Row = {"controller": controller, "source": OURS, "command_velocity": command}
    for name, column in (("success_rate", "survived"), ("tracking_rate", "tracked")):
        values = table[column].astype(float)
        row[name] = float(values.mean())
        row[f"{name}_std"] = _spread(values, trial)
    for name, column in (("mse", "squared_error"), ("mse_steady", "squared_error_steady")):
        values = table[column][survived]
        row[name] = float(values.mean()) if len(values) else float("inf")
        row[f"{name}_std"] = _spread(values, trial[survived])
    return row


def quality_row(
    controller: str, command: float, table: records.Records, reference: float | None
) -> Row:
    """Means over surviving robots of the gait's quality; empty where none survived.

    ``reference`` is the variance of the forward velocity within the library's gait at the command
    [m²/s²]; it stands beside the controller's own and is empty where there is no such gait.
    """
    row: Row = {"controller": controller, "command_velocity": command}
    for name in ("mean_velocity", *records.QUALITY):
        values = table[name][table["survived"]]
        row[name] = float(values.mean()) if len(values) else ""
        if name == "velocity_variance":
            row[f"reference_{name}"] = "" if reference is None else reference
    return row


def reference_sway(inputs: Inputs) -> Callable[[float], float | None]:
    """Forward velocity → variance within the gait of the input ``library``, if there is one."""
    if "library" not in inputs:
        return lambda command: None
    library = LibraryContents.load(inputs["library"][0] / "library.zarr")
    return lambda command: forward_variance(library, command)


def paper_rows() -> list[Row]:
    """The paper's own Table 1, labelled as the paper's; it states no spread."""
    text = (files("slider.reports") / _PAPER_TABLE).read_text()
    rows: list[Row] = []
    for entry in csv.DictReader(text.splitlines()):
        row: Row = dict.fromkeys(COLUMNS, "")
        row |= {
            "controller": entry["controller"],
            "source": PAPER,
            "command_velocity": float(entry["command_velocity"]),
            "success_rate": float(entry["success_rate"]),
            "mse": float(entry["mse"]),
        }
        rows.append(row)
    return rows


def read_evaluation(folder: Path) -> tuple[str, float, records.Records]:
    """Controller, command [m/s] and records of an evaluation."""
    about = json.loads((folder / "command.json").read_text())
    return about["controller"], about["command"], records.read(folder / records.FILE)


def _spread(values: np.ndarray, trial: np.ndarray) -> float | str:
    """Standard deviation over trials of the trial means; empty for fewer than two trials."""
    means = [values[trial == t].mean() for t in np.unique(trial)]
    return float(np.std(means, ddof=1)) if len(means) > 1 else ""


def write_table(rows: list[Row], columns: tuple[str, ...], path: Path) -> None:
    """Write a CSV file; numbers keep six digits."""
    lines = [",".join(columns)]
    lines += [",".join(_text(row[name]) for name in columns) for row in rows]
    path.write_text("\n".join(lines) + "\n")


def _text(value: str | float) -> str:
    return value if isinstance(value, str) else f"{value:.6g}"
