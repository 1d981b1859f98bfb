"""Stages of figures and tables from evaluations: velocity over time, and the protocols' reports.

A protocol is of constant speeds (``sweep``), of segments of one case (``joystick``), or of cases
(``heldout``); each has a table, a figure and their explanation.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from slider.config.convert import from_dict
from slider.config.evaluation import EvaluationConfig, Segment
from slider.core.errors import require
from slider.core.job import Inputs, Job, Section, Summary
from slider.core.tables import Table
from slider.evaluation.results import AXES, MEASURES, Evaluation, Robots, wilson
from slider.evaluation.segments import SMOOTHING, profile_of
from slider.reports import rows as tables
from slider.reports.document import picture, write_document
from slider.reports.figures import walking
from slider.reports.figures.style import write_pictures
from slider.reports.quantities import NONE, QUANTITIES, Quantity, speed_text
from slider.reports.rows import NAN, Row, by, distinct
from slider.reports.table1 import comparisons

TRACKING = "velocity_tracking"
TRACKED_SHARE = 0.9
"""Share of the robots that must track a speed for it to count as tracked."""
STANDING = 0.1
"""A robot that stands is slower than this [m/s]."""
MEANS = {  # column of the table of cases → measure of the last segment
    "mse_steady": "vx_mse",
    **{name: name for name in ("vx", "vy", "vx_error", "vy_error", "heading_error")},
}
STOPPED = ("standing_rate", "standing_low", "standing_high", "fastest", "drift", "drift_max")
TRACKING_CAPTION = (
    "Forward velocity from rest: mean over surviving robots, the band is one standard deviation "
    "between robots, dashed the command."
)
_SPEEDS_CAPTION = """\
{trials} trials of {robots} robots per controller and speed, {duration:g} s from rest. What is
drawn counts from {warm_up:g} s on: mean forward speed (band: one standard deviation between
robots), share of robots that stay up (line) and that track (dots: mean speed within
max({tracking_tolerance:g} m/s, {tracking_relative:.0%}) of the command), and mean squared error.
± is the standard deviation over trials, of the mean speed that between robots; brackets hold
Wilson's 95 % interval. Speeds and errors are those of robots that stay up. `{name}.csv` has all
numbers, and how the robots walk.

A speed counts as tracked where at least {share:.0%} of the robots track it.
"""
_SEGMENTS_CAPTION = """\
{trials} trials of {robots} robots per controller. Commanded (black) and measured forward and
leftward velocity and yaw rate: mean and one standard deviation between the robots that are still
up, each a moving average over {window:g} s, since a walking base sways within a step. Below, the
share of robots that are still up.

In the tables a segment counts from {settled:g} s after its start; the numbers are means over the
robots that are up at its end. Errors are |mean − command|; the heading error is the largest
deviation from the commanded heading, the integral of the yaw rate; touchdowns are those of both
feet; the displacement is how far the base got. `{name}.csv` has all numbers.
"""
_CASES_CAPTION = """\
Share of robots that survive the case (dot) and that stand after it (ring), with Wilson's 95 %
interval. {trials} trials of {robots} robots per controller and case, {duration:g} s each, from
rest. A robot survives a case if it stays up for all of it. The other numbers are those of
survivors, from {settled:g} s after the case's last command on. Where that command is zero, a robot
stands if all means of its velocity over {smoothing:g} s stay below {standing:g} m/s; the fastest
robot has the largest of these means, and the drift is how far the base got. Brackets hold Wilson's
95 % interval. `{name}.csv` has all numbers.
"""
_SEGMENT_COLUMNS = (
    *("success_rate", "vx_error", "vy_error", "yaw_rate_error", "heading_error"),
    *("touchdown_rate", "displacement"),
)


def run_tracking(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write table, figure and Markdown of forward velocities over time.

    Raises:
        UserError: none of the speeds is evaluated.
    """
    speeds, period = section["speeds"], section["control_period"]
    evaluations = tables.evaluations(inputs["evaluations"], section["labels"])
    expected = "at least one of evaluation.speeds"
    require(bool(evaluations), "report.tracking_speeds", expected, speeds)
    rows = [row for one in evaluations for row in _tracking_rows(one, period)]
    shown = [picture(TRACKING), TRACKING_CAPTION, *undrawn(evaluations, speeds)]
    draw = partial(walking.draw_tracking, evaluations, period)
    title = "Forward velocity over time"
    _write(out / TRACKING, (title, section["robot"]), rows, draw, shown, job)
    return {"rows": len(rows)}


def _tracking_rows(one: Evaluation, period: float) -> Iterator[Row]:
    """A row per control step: the time of its end [s], mean and spread over survivors [m/s]."""
    values = one.velocity if one.robots.survived.any() else np.full_like(one.velocity, NAN)
    for step, (mean, spread) in enumerate(values.tolist(), start=1):
        row = tables.named(one) | {"speed": one.speed, "time": period * step}
        yield row | {"mean_velocity": mean, "mean_velocity_spread": spread}


def undrawn(evaluations: Sequence[Evaluation], speeds: Sequence[float]) -> Iterator[str]:
    """Curves that are not drawn, and why."""
    evaluated = {one.speed for one in evaluations}
    missing = ", ".join(speed_text(value) for value in speeds if value not in evaluated)
    if missing:
        yield f"Not drawn: {missing} m/s, not evaluated in this run."
    fallen = [
        f"{one.label} at {speed_text(one.speed)} m/s"
        for one in evaluations
        if one.speed is not None and one.speed in speeds and not one.robots.survived.any()
    ]
    if fallen:
        yield f"Not drawn: no survivors with {'; '.join(fallen)}."


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write ``NAME.csv``, ``NAME.md`` and ``NAME.svg`` of a protocol."""
    name, protocol = section["name"], from_dict(EvaluationConfig, section["evaluation"])
    evaluations = tables.evaluations(inputs["evaluations"], section["labels"])
    title, _, rows_of, draw, _ = _KINDS[_kind(protocol)]
    rows = list(rows_of(evaluations, protocol))
    shown = blocks(name, rows, protocol)
    figure = partial(draw, rows, evaluations, protocol)
    _write(out / name, (title, section["robot"]), rows, figure, shown, job)
    if protocol.profile is not None:
        # Of all cases, or at the end.
        pick = min if protocol.profile.rows == "cases" else lambda rates: rates[-1]
        groups = by(rows, "controller").items()
        rates = {who: pick([row["success_rate"] for row in mine]) for who, mine in groups}
        return {"rows": len(rows), "success_rate": rates}
    highest = highest_tracked(rows)
    metrics = {f"highest_tracked/{c}": value for c, value in highest.items() if value is not None}
    job.log_metrics(metrics, 0)
    return {"rows": len(rows), "highest_tracked": highest}


def _write(
    stem: Path,
    about: tuple[str, str],
    rows: list[Row],
    draw: Callable[[], Figure],
    parts: Iterable[str],
    job: Job,
) -> None:
    """Write ``stem``.csv, .svg and .md; ``about`` are a title and the robot's name."""
    tables.write(rows, stem.with_suffix(".csv"))
    write_pictures(stem, draw)
    title, robot = about
    write_document(stem.with_suffix(".md"), f"{title}: {stem.name}", robot, parts)


def blocks(name: str, rows: Sequence[Row], protocol: EvaluationConfig) -> Iterator[str]:
    """The figure of a protocol, its explanation and its tables."""
    _, caption, _, _, tables_of = _KINDS[_kind(protocol)]
    values = {"name": name, "share": TRACKED_SHARE, "smoothing": SMOOTHING, "standing": STANDING}
    if profile := protocol.profile:
        values |= {"window": profile.window, "settled": profile.warm_up}
    yield picture(name)
    yield caption.format(**vars(protocol), **values)
    yield from (table.markdown for table in tables_of(rows))


def _kind(protocol: EvaluationConfig) -> str:
    return protocol.profile.rows if protocol.profile else "speeds"


def _speed_rows(evaluations: Sequence[Evaluation], protocol: EvaluationConfig) -> Iterator[Row]:
    """Rows of Table 1, how the robots walk, and the spread of their mean speeds."""
    for one in evaluations:
        speeds = one.robots.survivors("mean_velocity")
        between = {"mean_velocity_spread": float(speeds.std()) if len(speeds) else NAN}
        yield tables.table_row(one) | tables.quality_row(one) | between


def _speed_tables(rows: Sequence[Row]) -> Iterator[Table]:
    """What is tracked, mean speeds with their spread between robots, and the metrics."""
    yield _highest_table(rows)
    cells = {}
    for row in rows:
        mean, spread = row["mean_velocity"], row["mean_velocity_spread"]
        text = f"{round(mean, 3) + 0.0:.3f} ± {spread:.3f}"  # no -0.000
        cells[row["label"], row["speed"]] = text if mean == mean else NONE
    labels = list(by(rows, "label"))
    body = [
        [speed_text(value), *(cells[name, value] for name in labels)]
        for value in distinct(rows, "speed")
    ]
    yield Table(["command [m/s]", *labels], body, "Mean speed [m/s]")
    yield from comparisons(rows)


def highest_tracked(rows: Sequence[Row]) -> dict[str, float | None]:
    """Highest commanded speed [m/s] that each controller tracks; None where it tracks none."""
    return {
        controller: max((row["speed"] for row in mine if _tracked(row)), default=None)
        for controller, mine in by(rows, "controller").items()
    }


def _tracked(row: Row) -> bool:
    return row["tracking_rate"] >= TRACKED_SHARE


def _highest_table(rows: Sequence[Row]) -> Table:
    """Highest speed that each controller tracks, and lower ones that it does not."""
    body = []
    for controller, top in highest_tracked(rows).items():
        mine = by(rows, "controller")[controller]
        lost = [row["speed"] for row in mine if not _tracked(row)]
        lower = ", ".join(speed_text(value) for value in lost if value < (top or 0.0)) or "none"
        body.append([mine[0]["label"], "none" if top is None else speed_text(top), lower])
    heads = ["controller", "highest tracked speed [m/s]", "lower speeds that it does not track"]
    return Table(heads, body)


def _segment_rows(evaluations: Sequence[Evaluation], protocol: EvaluationConfig) -> Iterator[Row]:
    """A row per segment: means over the robots that are up at its end."""
    (case,) = profile_of(protocol).cases
    for one in evaluations:
        for segment, robots in zip(case.segments, one.segments, strict=True):
            row = tables.named(one) | {"segment": segment.name, "time": segment.time}
            row |= _commands(segment) | robots.success()
            yield row | {name: robots.mean(name) for name in MEASURES}


def _commands(segment: Segment) -> Row:
    return {f"{axis}_command": getattr(segment, axis) for axis in AXES}


def _segment_tables(rows: Sequence[Row]) -> Iterator[Table]:
    """A table per controller with a row per segment."""
    heads = ["from [s]", "segment", "vx, vy, yaw rate"]
    heads += [QUANTITIES[column].heading for column in _SEGMENT_COLUMNS]
    for label, mine in by(rows, "label").items():
        body = []
        for row in mine:
            velocity = ", ".join(f"{row[f'{axis}_command']:g}" for axis in AXES)
            numbers = (QUANTITIES[name].text(row[name]) for name in _SEGMENT_COLUMNS)
            name = row["segment"].replace("_", " ")
            body.append([f"{row['time']:g}", name, velocity, *numbers])
        yield Table(heads, body, label)


def _case_rows(evaluations: Sequence[Evaluation], protocol: EvaluationConfig) -> Iterator[Row]:
    """Success, and what survivors did in the settled last segment; NaN where none survived.

    ``vx_before`` is the command before the last one [m/s], if there was another.
    """
    cases = {case.name: case for case in profile_of(protocol).cases}
    for one in evaluations:
        *others, final = cases[str(one.case)].segments
        last, commands = one.segments[-1], _commands(final)
        row = tables.named(one) | {"case": one.case, "seconds": protocol.duration}
        row |= {"vx_before": others[-1].vx if others else NAN} | commands | last.success()
        row |= {name: last.mean(measure) for name, measure in MEANS.items()}
        stops = not any(commands.values())
        yield row | (_standing(last) if stops else dict.fromkeys(STOPPED, NAN))


def _standing(robots: Robots) -> Row:
    """Share of all robots that survived and stood; of survivors the fastest, and the drift [m]."""
    fastest, drift = robots.survivors("fastest"), robots.survivors("displacement")
    standing, count = int((fastest < STANDING).sum()), len(robots.survived)
    fast, far = (float(values.max()) if len(values) else NAN for values in (fastest, drift))
    ends = wilson(standing, count)
    values = (standing / count, *ends, fast, robots.mean("displacement"), far)
    return dict(zip(STOPPED, values, strict=True))


_CONSTANT, _STANDS = "Constant speeds", f"Standing (slower than {STANDING:g} m/s)"
_CASE_COLUMNS = {
    _CONSTANT: ("vx", "vy", "mse_steady", "heading_error"),
    _STANDS: ("standing_rate", "fastest", "drift", "drift_max", "vx", "vy", "mse_steady"),
    "Sideways": ("vy", "vy_error", "vx", "mse_steady"),
}


def _case_tables(rows: Sequence[Row]) -> Iterator[Table]:
    """Of each controller constant speeds, standing and sideways, without empty tables."""
    for label, mine in by(rows, "label").items():
        for title, columns in _CASE_COLUMNS.items():
            shown = {name: QUANTITIES[MEANS.get(name, name)] for name in ("success_rate", *columns)}
            body = [
                [row["case"], f"{row['seconds']:g}"]
                + [_case_cell(quantity, row, name) for name, quantity in shown.items()]
                for row in mine
                if _case_title(row) == title
            ]
            if body:
                heads = ["case", "time [s]", *(quantity.heading for quantity in shown.values())]
                yield Table(heads, body, f"{title}, {label}")


def _case_title(row: Row) -> str:
    if row["vy_command"] != 0:
        return "Sideways"
    return _CONSTANT if np.isnan(row["standing_rate"]) else _STANDS


def _case_cell(quantity: Quantity, row: Row, name: str) -> str:
    """A share with its interval."""
    prefix = name.removesuffix("_rate")
    ends = (row.get(f"{prefix}_{end}", NAN) for end in ("low", "high"))
    return quantity.between(row[name], *ends)


_KINDS: dict[str, tuple[str, str, Callable, Callable, Callable]] = {
    "speeds": (
        "Mean speed over the commanded speed",
        _SPEEDS_CAPTION,
        _speed_rows,
        lambda rows, evaluations, protocol: walking.draw_speeds(rows),
        _speed_tables,
    ),
    "segments": (
        "Changing commands",
        _SEGMENTS_CAPTION,
        _segment_rows,
        lambda rows, evaluations, protocol: walking.draw_segments(evaluations, protocol),
        _segment_tables,
    ),
    "cases": (
        "Cases",
        _CASES_CAPTION,
        _case_rows,
        lambda rows, evaluations, protocol: walking.draw_cases(rows),
        _case_tables,
    ),
}
"""Kind of protocols → title, caption, rows from evaluations, figure and tables of the rows."""
