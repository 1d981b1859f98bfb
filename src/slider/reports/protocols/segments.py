"""The report of one case segment by segment, such as the joystick."""

import json
from pathlib import Path

import numpy as np

from slider.config.convert import from_dict
from slider.config.evaluation import CaseConfig, EvaluationConfig
from slider.core.job import Inputs, Job, Section, Summary
from slider.evaluation import segments
from slider.evaluation.profile import command
from slider.reports.controllers import label
from slider.reports.figures.command_tracking import Trace, draw
from slider.reports.figures.publication import write_pictures
from slider.reports.rows import Row, success, write_rows

_TITLE = "# Changing commands: {name}"
_CAPTION = """\
{trials} trials of {robots} robots per controller. Commanded (black) and measured forward and
leftward velocity and yaw rate: mean and one standard deviation between the robots that are still
up, each a moving average over {window:g} s, since a walking base sways within a step. Below, the
share of robots that are still up.

In the tables a segment counts from {warm_up:g} s after its start; the numbers are means over the
robots that are up at its end. Errors are |mean − command| of vx and vy [m/s] and of the yaw rate
[rad/s]; `heading` is the largest deviation from the commanded heading, the integral of the yaw
rate [rad]; `touchdowns` are those of both feet per second; `displacement` is how far the base
got [m]. `reports/{name}.csv` has all numbers.
"""
_HEAD = (
    "| segment | vx, vy, yaw rate | up | error of vx | of vy | of yaw rate "
    "| heading | touchdowns | displacement |"
)
_SHOWN = ("vx_error", "vy_error", "yaw_rate_error", "heading_error", "touchdown_rate")


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write ``NAME.csv``, ``NAME.md``, ``NAME.svg`` and ``NAME.png``."""
    name, protocol = section["name"], from_dict(EvaluationConfig, section["evaluation"])
    (case,) = segments.profile_of(protocol).cases
    rows: list[Row] = []
    traces: list[Trace] = []
    for folder in inputs["evaluations"]:
        controller = json.loads((folder / "command.json").read_text())["controller"]
        rows += segment_rows(controller, case, segments.read(folder / segments.FILE))
        traces.append(Trace(controller, np.load(folder / segments.TRACES)))
    write_rows(rows, tuple(rows[0]), out / f"{name}.csv")
    write_pictures(out / name, lambda: draw(traces, case, protocol.duration))
    (out / f"{name}.md").write_text(_text(name, protocol, rows), encoding="utf-8")
    job.tracker.log_file(out / f"{name}.png")
    last = {str(row["controller"]): row["success_rate"] for row in rows}  # of the last segment
    return {"rows": len(rows), "success_rate": last}


def segment_rows(controller: str, case: CaseConfig, table: segments.Table) -> list[Row]:
    """One row per segment: means over the robots that are up at its end, empty without any."""
    rows: list[Row] = []
    for index, segment in enumerate(case.segments):
        mine = table["segment"] == index
        up, trial = table["survived"][mine], table["trial"][mine]
        commanded = dict(zip(segments.AXES, command(segment), strict=True))
        row: Row = {"controller": controller, "segment": segment.name, "time": segment.time}
        row |= {f"{axis}_command": value for axis, value in commanded.items()}
        row |= success(up, trial)
        for name in segments.MEASURES:
            values = table[name][mine][up]
            row[name] = float(values.mean()) if len(values) else ""
        rows.append(row)
    return rows


def _text(name: str, protocol: EvaluationConfig, rows: list[Row]) -> str:
    profile = segments.profile_of(protocol)
    caption = _CAPTION.format(
        name=name,
        trials=protocol.trials,
        robots=protocol.robots,
        window=profile.window,
        warm_up=profile.warm_up,
    )
    lines = [_TITLE.format(name=name), "", f"![{name}](figures/{name}.png)", "", caption]
    for controller in dict.fromkeys(str(row["controller"]) for row in rows):
        lines += [f"## {label(controller)}", "", _HEAD, "|---" * 9 + "|"]
        lines += [_line(row) for row in rows if row["controller"] == controller]
        lines.append("")
    return "\n".join(lines)


def _line(row: Row) -> str:
    wanted = ", ".join(f"{float(row[f'{axis}_command']):g}" for axis in segments.AXES)
    cells = [str(row["segment"]), wanted, f"{float(row['success_rate']):.0%}"]
    cells += ["–" if row[n] == "" else f"{float(row[n]):.3f}" for n in (*_SHOWN, "displacement")]
    return f"| {' | '.join(cells)} |"
