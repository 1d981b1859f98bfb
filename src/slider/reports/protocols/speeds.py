"""The report of a protocol of constant forward velocities, such as the sweep."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from slider.config.convert import from_dict
from slider.config.evaluation import EvaluationConfig
from slider.core.job import Inputs, Job, Section, Summary
from slider.evaluation.results import Evaluation
from slider.reports import rows as tables
from slider.reports.comparison import comparisons
from slider.reports.controllers import speed
from slider.reports.figures.protocols import draw_speeds
from slider.reports.protocols import write
from slider.reports.rows import NAN, Row, by, distinct
from slider.reports.table import Cell, Picture, Table, Tables, Text, Written

TRACKED_SHARE = 0.9  # of the robots that must track a command for it to count as tracked
_CAPTION = """\
{trials} trials of {robots} robots per controller and command, {duration:g} s from rest. What is
drawn counts from {steady:g} s on: mean forward speed (band: one standard deviation between
robots), share of robots that stay up (line) and that track (dots: mean speed within
max({tolerance:g} m/s, {relative:.0%}) of the command), and mean squared error. ± is the standard
deviation over trials, of the mean speed that between robots; brackets hold Wilson's 95 % interval.
Speeds and errors are those of robots that stay up. `reports/{name}.csv` has all numbers, and how
the robots walk.

A speed counts as tracked where at least {share:.0%} of the robots track it.
"""


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write ``NAME.csv``, ``NAME.md``, ``NAME.svg`` and ``NAME.png``."""
    name, protocol = section["name"], from_dict(EvaluationConfig, section["evaluation"])
    rows = read_rows(tables.evaluations(inputs["evaluations"], section["labels"]), protocol)
    shown = blocks(name, out / f"{name}.svg", rows, protocol)
    title = "Mean speed over the commanded speed"
    write(out / name, title, rows, lambda: draw_speeds(rows), shown, job)
    highest = highest_tracked(rows)
    known = {f"highest_tracked/{c}": value for c, value in highest.items() if value is not None}
    job.tracker.log_metrics(known, 0)
    return {"rows": len(rows), "highest_tracked": highest}


def read_rows(evaluations: Sequence[Evaluation], protocol: EvaluationConfig) -> list[Row]:
    """A row of Table 1 and how the robots walk, with the spread of the mean speed over robots."""
    return [_row(one) for one in evaluations]


def _row(evaluation: Evaluation) -> Row:
    speeds = evaluation.robots.survivors("mean_velocity")
    between = {"mean_velocity_spread": float(speeds.std()) if len(speeds) else NAN}
    return tables.table_row(evaluation) | tables.quality_row(evaluation) | between


def highest_tracked(rows: Sequence[Row]) -> dict[str, float | None]:
    """Highest commanded speed [m/s] that each controller tracks; None where it tracks none."""
    return {
        controller: max((row["command_velocity"] for row in mine if _tracked(row)), default=None)
        for controller, mine in by(rows, "controller").items()
    }


def _tracked(row: Row) -> bool:
    return row["tracking_rate"] >= TRACKED_SHARE


def blocks(name: str, svg: Path, rows: list[Row], protocol: EvaluationConfig) -> Iterator[Written]:
    """The figure, the highest tracked speeds, mean speeds, and Table 1's tables."""
    about = _CAPTION.format(
        name=name,
        trials=protocol.trials,
        robots=protocol.robots,
        duration=protocol.duration,
        steady=protocol.warm_up,
        tolerance=protocol.tracking_tolerance,
        relative=protocol.tracking_relative,
        share=TRACKED_SHARE,
    )
    yield Picture(svg)
    yield Text(about)
    yield highest_table(rows)
    yield Tables([_mean_speeds(rows), *comparisons(rows)])


def highest_table(rows: Sequence[Row]) -> Table:
    """Highest speed that each controller tracks, and lower ones that it does not."""
    body = []
    for label, mine in by(rows, "label").items():
        highest = max((row["command_velocity"] for row in mine if _tracked(row)), default=None)
        lost = [row["command_velocity"] for row in mine if not _tracked(row)]
        lower = ", ".join(speed(v) for v in lost if v < (highest or 0.0)) or "none"
        found = "none" if highest is None else speed(highest)
        body.append([Cell(label), Cell(found), Cell(lower)])
    heads = ["controller", "highest tracked speed [m/s]", "lower speeds that it does not track"]
    return Table(heads, body, sortable=False)


def _mean_speeds(rows: Sequence[Row]) -> Table:
    """Mean speed and its spread between robots: commands down, controllers across."""
    found = {(row["label"], row["command_velocity"]): row for row in rows}
    labels = list(by(rows, "label"))
    body = [
        [Cell(speed(command), command), *(_speed(found[name, command]) for name in labels)]
        for command in distinct(rows, "command_velocity")
    ]
    return Table(["command [m/s]", *labels], body, "Mean speed [m/s]")


def _speed(row: Row) -> Cell:
    mean, spread = row["mean_velocity"], row["mean_velocity_spread"]
    if mean != mean:
        return Cell("–")
    return Cell(f"{round(mean, 3) + 0.0:.3f} ± {spread:.3f}", mean)  # no -0.000
