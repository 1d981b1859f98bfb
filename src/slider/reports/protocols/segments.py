"""The report of one case segment by segment, such as the joystick."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from slider.config.convert import from_dict
from slider.config.evaluation import EvaluationConfig
from slider.core.job import Inputs, Job, Section, Summary
from slider.evaluation.results import AXES, MEASURES, Evaluation
from slider.evaluation.segments import command, profile_of
from slider.reports import rows as tables
from slider.reports.figures.protocols import draw_segments
from slider.reports.protocols import write
from slider.reports.quantities import QUANTITIES
from slider.reports.rows import Row, by
from slider.reports.table import Cell, Picture, Table, Text, Written

_CAPTION = """\
{trials} trials of {robots} robots per controller. Commanded (black) and measured forward and
leftward velocity and yaw rate: mean and one standard deviation between the robots that are still
up, each a moving average over {window:g} s, since a walking base sways within a step. Below, the
share of robots that are still up.

In the tables a segment counts from {warm_up:g} s after its start; the numbers are means over the
robots that are up at its end. Errors are |mean − command|; the heading error is the largest
deviation from the commanded heading, the integral of the yaw rate; touchdowns are those of both
feet; the displacement is how far the base got. `reports/{name}.csv` has all numbers.
"""
_SHOWN = (
    "success_rate",
    "vx_error",
    "vy_error",
    "yaw_rate_error",
    "heading_error",
    "touchdown_rate",
    "displacement",
)


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write ``NAME.csv``, ``NAME.md``, ``NAME.svg`` and ``NAME.png``."""
    name, protocol = section["name"], from_dict(EvaluationConfig, section["evaluation"])
    (case,) = profile_of(protocol).cases
    evaluations = tables.evaluations(inputs["evaluations"], section["labels"])
    rows = read_rows(evaluations, protocol)
    shown = blocks(name, out / f"{name}.svg", rows, protocol)
    title, seconds = "Changing commands", protocol.duration
    write(out / name, title, rows, lambda: draw_segments(evaluations, case, seconds), shown, job)
    last = {row["controller"]: row["success_rate"] for row in rows}  # of the last segment
    return {"rows": len(rows), "success_rate": last}


def read_rows(evaluations: Sequence[Evaluation], protocol: EvaluationConfig) -> list[Row]:
    """One row per controller and segment: means over the robots that are up at its end."""
    (case,) = profile_of(protocol).cases
    rows: list[Row] = []
    for one in evaluations:
        for segment, robots in zip(case.segments, one.segments, strict=True):
            row = tables.named(one) | {"segment": segment.name, "time": segment.time}
            asked = zip(AXES, command(segment), strict=True)
            row |= {f"{axis}_command": value for axis, value in asked}
            row |= tables.success(robots) | {name: robots.mean(name) for name in MEASURES}
            rows.append(row)
    return rows


def blocks(name: str, svg: Path, rows: list[Row], protocol: EvaluationConfig) -> Iterator[Written]:
    """The figure, and a table per controller with a row per segment."""
    profile = profile_of(protocol)
    yield Picture(svg)
    yield Text(
        _CAPTION.format(
            name=name,
            trials=protocol.trials,
            robots=protocol.robots,
            window=profile.window,
            warm_up=profile.warm_up,
        )
    )
    heads = ["from [s]", "segment", "vx, vy, yaw rate"]
    heads += [QUANTITIES[column].heading for column in _SHOWN]
    for label, mine in by(rows, "label").items():
        yield Table(heads, [_cells(row) for row in mine], label)


def _cells(row: Row) -> list[Cell]:
    asked = ", ".join(f"{row[f'{axis}_command']:g}" for axis in AXES)
    return [
        Cell(f"{row['time']:g}", row["time"]),
        Cell(row["segment"].replace("_", " "), row["segment"]),
        Cell(asked, asked),
        *(Cell.of(QUANTITIES[name], row[name]) for name in _SHOWN),
    ]
