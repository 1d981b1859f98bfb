"""The stage ``table1``: ours beside the paper's, one row per controller and command."""

import csv
from importlib.resources import files
from pathlib import Path

import numpy as np

from slider.core.job import Inputs, Job, Section, Summary
from slider.reports import table1_text
from slider.reports.comparison import read_rows
from slider.reports.controllers import PAPER
from slider.reports.rows import (
    Row,
    quality_row,
    read_evaluation,
    reference_gaits,
    table_row,
    with_reference,
    write_rows,
)

COLUMNS = (
    "controller",
    "source",
    "command_velocity",
    "success_rate",
    "success_rate_std",
    "success_low",
    "success_high",
    "mse",
    "mse_std",
    "mse_steady",
    "mse_steady_std",
    "tracking_rate",
    "tracking_rate_std",
)
_PAPER_TABLE = "paper_table1.csv"


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write Table 1 as CSV, Markdown and LaTeX, and a table about the quality of the gait."""
    evaluations = [read_evaluation(folder) for folder in inputs["evaluations"]]
    rows = [table_row(*evaluation) for evaluation in evaluations]
    write_rows(rows + paper_rows(), COLUMNS, out / "table1.csv")
    reference = reference_gaits(inputs)
    quality = [with_reference(quality_row(*evaluation), reference) for evaluation in evaluations]
    write_rows(quality, tuple(quality[0]), out / "gait_quality.csv")
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
