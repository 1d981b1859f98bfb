"""The report of a profile's cases, each by its last segment, such as the held-out commands."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from slider.config.convert import from_dict
from slider.config.evaluation import CaseConfig, EvaluationConfig
from slider.core.job import Inputs, Job, Section, Summary
from slider.evaluation.results import AXES, Evaluation, Robots, wilson
from slider.evaluation.segments import SMOOTHING, command, profile_of
from slider.reports import rows as tables
from slider.reports.figures.protocols import draw_cases
from slider.reports.protocols import write
from slider.reports.quantities import QUANTITIES, Quantity
from slider.reports.rows import NAN, Row, by
from slider.reports.table import Cell, Picture, Table, Text, Written

STANDING = 0.1  # a robot that stands is slower than this [m/s]
MEANS = {  # column of the table → measure of the last segment
    "mse_steady": "vx_mse",
    **{name: name for name in ("vx", "vy", "vx_error", "vy_error", "heading_error")},
}
STOPPED = ("standing_rate", "standing_low", "standing_high", "fastest", "drift", "drift_max")
_CAPTION = """\
{trials} trials of {robots} robots per controller and case, {duration:g} s each, from rest. A robot
survives a case if it stays up for all of it. The other numbers are those of survivors, from
{warm_up:g} s after the case's last command on. Where that command is zero, a robot stands if all
means of its velocity over {smoothing:g} s stay below {standing:g} m/s; the fastest robot has the
largest of these means, and the drift is how far the base got. Brackets hold Wilson's 95 %
interval. `reports/{name}.csv` has all numbers.
"""
_FIGURE = (
    "Share of robots that survive the case (dot) and that stand after it (ring), with Wilson's "
    "95 % interval; errors of the mean velocity, and the fastest robot after a stop (diamond)."
)


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write ``NAME.csv``, ``NAME.md``, ``NAME.svg`` and ``NAME.png``."""
    name, protocol = section["name"], from_dict(EvaluationConfig, section["evaluation"])
    rows = read_rows(tables.evaluations(inputs["evaluations"], section["labels"]), protocol)
    shown = blocks(name, out / f"{name}.svg", rows, protocol)
    write(out / name, "Cases", rows, lambda: draw_cases(rows), shown, job)
    groups = by(rows, "controller").items()
    least = {controller: min(r["success_rate"] for r in mine) for controller, mine in groups}
    return {"rows": len(rows), "success_rate": least}


def read_rows(evaluations: Sequence[Evaluation], protocol: EvaluationConfig) -> list[Row]:
    """One row per controller and case."""
    cases = {case.name: case for case in profile_of(protocol).cases}
    return [_row(one, cases[one.case], protocol.duration) for one in evaluations]


def _row(evaluation: Evaluation, case: CaseConfig, seconds: float) -> Row:
    """Success, and what survivors did in the settled last segment; NaN where none survived.

    ``vx_before`` is the command before the last one [m/s], if there was another.
    """
    last, asked = evaluation.segments[-1], command(case.segments[-1])
    before = case.segments[-2].vx if len(case.segments) > 1 else NAN
    row = tables.named(evaluation) | {"case": case.name, "seconds": seconds}
    row |= {"vx_before": before}
    row |= {f"{axis}_command": value for axis, value in zip(AXES, asked, strict=True)}
    row |= tables.success(last) | {name: last.mean(measure) for name, measure in MEANS.items()}
    return row | (dict.fromkeys(STOPPED, NAN) if any(asked) else _standing(last))


def _standing(robots: Robots) -> Row:
    """Share of all robots that survived and stood; of survivors the fastest, and the drift [m]."""
    fastest, drift = robots.survivors("fastest"), robots.survivors("displacement")
    standing, count = int((fastest < STANDING).sum()), len(robots.survived)
    low, high = wilson(standing, count)
    values = (
        standing / count,
        low,
        high,
        float(fastest.max()) if len(fastest) else NAN,
        robots.mean("displacement"),
        float(drift.max()) if len(drift) else NAN,
    )
    return dict(zip(STOPPED, values, strict=True))


def blocks(name: str, svg: Path, rows: list[Row], protocol: EvaluationConfig) -> Iterator[Written]:
    """The figure, and up to three tables per controller."""
    caption = _CAPTION.format(
        name=name,
        trials=protocol.trials,
        robots=protocol.robots,
        duration=protocol.duration,
        warm_up=profile_of(protocol).warm_up,
        smoothing=SMOOTHING,
        standing=STANDING,
    )
    yield Picture(svg, _FIGURE)
    yield Text(caption)
    yield from case_tables(rows)


def case_tables(rows: list[Row]) -> Iterator[Table]:
    """Of each controller constant speeds, standing and sideways, without those of no case."""
    for label, mine in by(rows, "label").items():
        for title, chosen, columns in _KINDS:
            shown = [row for row in mine if chosen(row)]
            if shown:
                yield _table(f"{title}, {label}", shown, columns)


def _table(title: str, rows: list[Row], columns: Sequence[str]) -> Table:
    names = ("success_rate", *columns)
    heads = ["case", "time [s]", *(_quantity(name).heading for name in names)]
    body = [
        [Cell(row["case"], row["case"]), Cell(f"{row['seconds']:g}", row["seconds"])]
        + [_cell(row, name) for name in names]
        for row in rows
    ]
    return Table(heads, body, title)


def _cell(row: Row, name: str) -> Cell:
    quantity, ends = _quantity(name), name.removesuffix("_rate")
    if not name.endswith("_rate"):
        return Cell.of(quantity, row[name])
    return Cell(quantity.between(row[name], row[f"{ends}_low"], row[f"{ends}_high"]), row[name])


def _quantity(name: str) -> Quantity:
    return QUANTITIES[MEANS.get(name, name)]


def _stands(row: Row) -> bool:
    return not np.isnan(row["standing_rate"])


def _sideways(row: Row) -> bool:
    return row["vy_command"] != 0


def _straight(row: Row) -> bool:
    return not _sideways(row) and not _stands(row)


# Title, which cases, their columns beside those of all.
_KINDS: tuple[tuple[str, Callable[[Row], bool], tuple[str, ...]], ...] = (
    ("Constant speeds", _straight, ("vx", "vy", "mse_steady", "heading_error")),
    (
        f"Standing (slower than {STANDING:g} m/s)",
        _stands,
        ("standing_rate", "fastest", "drift", "drift_max", "vx", "vy", "mse_steady"),
    ),
    ("Sideways", _sideways, ("vy", "vy_error", "vx", "mse_steady")),
)
