"""The report of a profile's cases, each by its last segment, such as the held-out commands."""

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from slider.config.convert import from_dict
from slider.config.evaluation import CaseConfig, EvaluationConfig
from slider.core.job import Inputs, Job, Section, Summary
from slider.evaluation import segments
from slider.evaluation.profile import command
from slider.reports.controllers import label
from slider.reports.figures.case_results import draw
from slider.reports.figures.publication import write_pictures
from slider.reports.proportions import wilson
from slider.reports.rows import Row, success, write_rows

STANDING = 0.1  # a robot that stands is slower than this [m/s]
MEANS = {  # column of the table → measure of the last segment
    "mse_steady": "vx_mse",
    **{name: name for name in ("vx", "vy", "vx_error", "vy_error", "heading_error")},
}
STOPPED = ("standing_rate", "standing_low", "standing_high", "fastest", "drift", "drift_max")
# Column → heading of what people compare.
COLUMNS = {
    "success_rate": "survived",
    "vx": "vx [m/s]",
    "vy": "vy [m/s]",
    "vy_error": "error of vy [m/s]",
    "mse_steady": "MSE of vx [m²/s²]",
    "standing_rate": "standing",
    "fastest": "fastest [m/s]",
    "drift": "drift [m]",
}
_INTERVALS = {
    "success_rate": ("success_low", "success_high"),
    "standing_rate": ("standing_low", "standing_high"),
}
_CAPTION = """\
{trials} trials of {robots} robots per controller and case, {duration:g} s each, from rest. A robot
survives a case if it stays up for all of it. The other numbers are those of survivors, from
{warm_up:g} s after the case's last command on. Where that command is zero, a robot stands if all
means of its velocity over {smoothing:g} s stay below {standing:g} m/s; `fastest` is the largest of
these means over all robots, and `drift` how far the base got, on average. Brackets hold Wilson's
95 % interval. `reports/{name}.csv` has all numbers.
"""


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write ``NAME.csv``, ``NAME.md``, ``NAME.svg`` and ``NAME.png``."""
    name, protocol = section["name"], from_dict(EvaluationConfig, section["evaluation"])
    cases = {case.name: case for case in segments.profile_of(protocol).cases}
    rows: list[Row] = []
    for folder in inputs["evaluations"]:
        about = json.loads((folder / "command.json").read_text())
        table = segments.read(folder / segments.FILE)
        rows.append(case_row(about["controller"], cases[about["case"]], protocol.duration, table))
    write_rows(rows, tuple(rows[0]), out / f"{name}.csv")
    write_pictures(out / name, lambda: draw(rows))
    (out / f"{name}.md").write_text(_text(name, protocol, rows), encoding="utf-8")
    job.tracker.log_file(out / f"{name}.png")
    return {"rows": len(rows), "success_rate": _least(rows)}


def case_row(controller: str, case: CaseConfig, seconds: float, table: segments.Table) -> Row:
    """Success, and what survivors did in the settled last segment; empty where none survived.

    ``vx_before`` is the command before the last one [m/s], if there was another.
    """
    last = table["segment"] == len(case.segments) - 1
    up, trial = table["survived"][last], table["trial"][last]
    before = case.segments[-2].vx if len(case.segments) > 1 else ""
    row: Row = {"controller": controller, "case": case.name, "seconds": seconds}
    row["vx_before"] = before
    asked = command(case.segments[-1])
    row |= {f"{axis}_command": v for axis, v in zip(segments.AXES, asked, strict=True)}
    row |= success(up, trial)
    for name, measure in MEANS.items():
        values = table[measure][last][up]
        row[name] = float(values.mean()) if len(values) else ""
    stopped = not any(asked)
    return row | (_standing(table, last) if stopped else dict.fromkeys(STOPPED, ""))


def _standing(table: segments.Table, last: np.ndarray) -> Row:
    """Share of all robots that survived and stood; of survivors the fastest, and the drift [m]."""
    up = table["survived"][last]
    fastest, drift = table["fastest"][last][up], table["displacement"][last][up]
    standing = int((fastest < STANDING).sum())
    low, high = wilson(standing, len(up))
    row: Row = {"standing_rate": standing / len(up), "standing_low": low, "standing_high": high}
    for name, values, over in (
        ("fastest", fastest, np.max),
        ("drift", drift, np.mean),
        ("drift_max", drift, np.max),
    ):
        row[name] = float(over(values)) if len(values) else ""
    return row


def _least(rows: list[Row]) -> dict[str, float]:
    """Success of each controller in its worst case."""
    found: dict[str, float] = {}
    for row in rows:
        name, rate = str(row["controller"]), float(row["success_rate"])
        found[name] = min(rate, found.get(name, 1.0))
    return found


def _text(name: str, protocol: EvaluationConfig, rows: list[Row]) -> str:
    caption = _CAPTION.format(
        name=name,
        trials=protocol.trials,
        robots=protocol.robots,
        duration=protocol.duration,
        warm_up=segments.profile_of(protocol).warm_up,
        smoothing=segments.SMOOTHING,
        standing=STANDING,
    )
    lines = [f"# Cases: {name}", "", f"![{name}](figures/{name}.png)", "", caption]
    for controller in dict.fromkeys(str(row["controller"]) for row in rows):
        lines += [f"## {label(controller)}", "", f"| case | {' | '.join(COLUMNS.values())} |"]
        lines.append("|---" * (1 + len(COLUMNS)) + "|")
        for row in (row for row in rows if row["controller"] == controller):
            lines.append(f"| {row['case']} | {' | '.join(cell(row, n) for n in COLUMNS)} |")
        lines.append("")
    return "\n".join(lines)


def cell(row: Mapping[str, str | float], name: str) -> str:
    """A number of ``COLUMNS`` as people read it, a share with its interval; – without one."""
    if row[name] == "":
        return "–"
    if name not in _INTERVALS:
        return f"{float(row[name]):.4f}" if name == "mse_steady" else f"{float(row[name]):.3f}"
    low, high = (100 * float(row[end]) for end in _INTERVALS[name])
    return f"{100 * float(row[name]):.1f} % [{low:.1f}, {high:.1f}]"
