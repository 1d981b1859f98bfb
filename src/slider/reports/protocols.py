"""Stages of figures and tables from evaluations: velocity over time, and the protocols' reports.

A protocol has constant speeds (``sweep``), segments of one case (``joystick``), or cases
(``heldout``). Each report has tables with an explanation, the first two kinds also a figure.
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd

from slider.config.convert import from_dict
from slider.config.evaluation import EvaluationConfig, Segment
from slider.core.errors import require
from slider.core.job import Inputs, Job, Section, Summary
from slider.core.quantities import NONE, speed_text
from slider.core.tables import Table
from slider.evaluation.results import AXES, MEASURES, Evaluation, means, success, wilson
from slider.evaluation.segments import SMOOTHING, profile_of
from slider.reports import report
from slider.reports.figures import walking
from slider.reports.quantities import QUANTITIES
from slider.reports.report import picture
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
_CASE_FRAME = (
    *("controller", "label", "case", "seconds", "vx_before", *(f"{axis}_command" for axis in AXES)),
    *("success_rate", "success_rate_std", "success_low", "success_high", *MEANS, *STOPPED),
)
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
feet; the displacement is the base's in that time. `{name}.csv` has all numbers.
"""
_CASES_CAPTION = """\
{trials} trials of {robots} robots per controller and case, {duration:g} s each, from
rest. A robot survives a case if it stays up for all of it. The other numbers are those of
survivors, from {settled:g} s after the case's last command on. Where that command is zero, a robot
stands if all means of its velocity over {smoothing:g} s stay below {standing:g} m/s; the fastest
robot has the largest of these means, and the drift is the displacement of the base. Brackets hold
Wilson's 95 % interval. `{name}.csv` has all numbers.
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
    evaluations = report.load(inputs["evaluations"], section["labels"])
    expected = "at least one of evaluation.speeds"
    require(bool(evaluations), "report.tracking_speeds", expected, section["speeds"])
    frame = pd.concat([_velocities(one, section["control_period"]) for one in evaluations])
    parts = [picture(TRACKING), TRACKING_CAPTION]
    draw = partial(walking.draw_tracking, frame)
    title = f"Forward velocity over time: {TRACKING}"
    report.write(out / TRACKING, title, section["robot"], frame, parts, draw)
    return {"rows": len(frame)}


def _velocities(one: Evaluation, period: float) -> pd.DataFrame:
    """A row per control step: the time of its end [s], mean and spread over survivors [m/s]."""
    mean, spread = one.velocity.T.astype(float)
    columns = {"controller": one.controller, "label": one.label, "speed": one.speed}
    columns |= {"time": period * np.arange(1, len(mean) + 1)}
    return pd.DataFrame(columns | {"mean_velocity": mean, "mean_velocity_spread": spread})


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write ``NAME.csv``, ``NAME.md`` and, except for cases, ``NAME.svg`` of a protocol."""
    name, protocol = section["name"], from_dict(EvaluationConfig, section["evaluation"])
    evaluations = report.load(inputs["evaluations"], section["labels"])
    kind = protocol.profile.rows if protocol.profile else "speeds"
    title, caption, frame_of, tables_of = _KINDS[kind]
    frame = frame_of(evaluations, protocol)
    values = {"name": name, "share": TRACKED_SHARE, "smoothing": SMOOTHING, "standing": STANDING}
    if profile := protocol.profile:
        values |= {"window": profile.window, "settled": profile.warm_up}
    parts = [caption.format(**vars(protocol), **values), *tables_of(frame)]
    figure = {
        "speeds": partial(walking.draw_speeds, frame),
        "segments": partial(walking.draw_segments, evaluations, protocol),
    }.get(kind)
    if figure is not None:
        parts.insert(0, picture(name))
    report.write(out / name, f"{title}: {name}", section["robot"], frame, parts, figure)
    if kind != "speeds":
        rates = frame.groupby("controller", sort=False)["success_rate"]
        picked = rates.min() if kind == "cases" else rates.last()  # of all cases, or at the end
        return {"rows": len(frame), "success_rate": picked.to_dict()}
    return {"rows": len(frame), "highest_tracked": highest_tracked(frame)}


def _speeds(evaluations: Sequence[Evaluation], protocol: EvaluationConfig) -> pd.DataFrame:
    """Success, accuracy, how the robots walk, and the spread of their mean speeds."""
    frame = report.results(evaluations)
    alive = (one.robots.loc[one.robots["survived"], "mean_velocity"] for one in evaluations)
    return frame.assign(mean_velocity_spread=[values.std(ddof=0) for values in alive])


def _speed_tables(frame: pd.DataFrame) -> Iterator[Table]:
    """What is tracked, mean speeds with their spread between robots, and the metrics."""
    yield _highest_table(frame)
    texts = [
        f"{mean:z.3f} ± {spread:.3f}" if mean == mean else NONE
        for mean, spread in zip(frame["mean_velocity"], frame["mean_velocity_spread"], strict=True)
    ]
    cells = frame.assign(text=texts).groupby(["speed", "label"])["text"].last().unstack()
    cells = cells[frame["label"].unique()].fillna(NONE)
    body = [[speed_text(speed), *line] for speed, *line in cells.itertuples()]
    yield Table(["command [m/s]", *cells], body, "Mean speed [m/s]")
    yield from comparisons(frame)


def highest_tracked(frame: pd.DataFrame) -> dict[str, float | None]:
    """Highest commanded speed [m/s] that each controller tracks; None where it tracks none."""
    tracked = frame["speed"].where(frame["tracking_rate"] >= TRACKED_SHARE)
    highest = tracked.groupby(frame["controller"], sort=False).max()
    return {name: None if np.isnan(top) else top for name, top in highest.items()}


def _highest_table(frame: pd.DataFrame) -> Table:
    """Highest speed that each controller tracks, how it walks there, and lower untracked ones."""
    body = []
    for controller, top in highest_tracked(frame).items():
        mine = frame[frame["controller"] == controller].set_index("speed")
        lost = mine.index[(mine["tracking_rate"] < TRACKED_SHARE) & (mine.index < (top or 0))]
        at = ["none", NONE] if top is None else [speed_text(top), f"{mine.mean_velocity[top]:.2f}"]
        body.append([mine["label"].iloc[0], *at, ", ".join(map(speed_text, lost)) or "none"])
    heads = ["controller", "highest tracked speed [m/s]", "mean speed there [m/s]"]
    return Table([*heads, "lower speeds that it does not track"], body)


def _segments(evaluations: Sequence[Evaluation], protocol: EvaluationConfig) -> pd.DataFrame:
    """A row per segment: means over the robots that are up at its end."""
    (case,), rows = profile_of(protocol).cases, []
    for one in evaluations:
        for segment, robots in zip(case.segments, _parts(one), strict=True):
            row = {"controller": one.controller, "label": one.label, "segment": segment.name}
            row |= {"time": segment.time} | _commands(segment) | success(robots)
            rows.append(row | means(robots, MEASURES))
    return pd.DataFrame(rows)


def _parts(one: Evaluation) -> list[pd.DataFrame]:
    """Robots of each segment."""
    assert one.segments is not None
    return [robots for _, robots in one.segments.groupby("segment")]


def _commands(segment: Segment) -> dict[str, float]:
    return {f"{axis}_command": getattr(segment, axis) for axis in AXES}


def _segment_tables(frame: pd.DataFrame) -> Iterator[Table]:
    """A table per controller with a row per segment."""
    shown = {name: QUANTITIES[name] for name in _SEGMENT_COLUMNS}
    heads = ["from [s]", "segment", "vx, vy, yaw rate", *(each.heading for each in shown.values())]
    for label, mine in frame.groupby("label", sort=False):
        body = []
        for row in mine.to_dict("records"):
            velocity = ", ".join(f"{row[f'{axis}_command']:g}" for axis in AXES)
            start = [f"{row['time']:g}", row["segment"].replace("_", " "), velocity]
            body.append([*start, *(each.text(row[name]) for name, each in shown.items())])
        yield Table(heads, body, str(label))


def _cases(evaluations: Sequence[Evaluation], protocol: EvaluationConfig) -> pd.DataFrame:
    """Success, and what survivors did in the settled last segment; NaN where none survived.

    ``vx_before`` is the command before the last one [m/s], if there was another.
    """
    cases, rows = {case.name: case for case in profile_of(protocol).cases}, []
    for one in evaluations:
        *others, final = cases[one.case].segments
        last, commands = _parts(one)[-1], _commands(final)
        row = {"controller": one.controller, "label": one.label, "case": one.case}
        row |= {"seconds": protocol.duration, "vx_before": others[-1].vx if others else np.nan}
        row |= commands | success(last) | means(last, [*MEANS.values()])
        rows.append(row | ({} if any(commands.values()) else _standing(last)))
    names = {measure: column for column, measure in MEANS.items()}
    return pd.DataFrame(rows).rename(columns=names).reindex(columns=_CASE_FRAME)


def _standing(robots: pd.DataFrame) -> dict[str, float]:
    """Share of all robots that survived and stood; greatest speed and drift [m] of survivors."""
    alive = robots[robots["survived"]]
    standing, count = int((alive["fastest"] < STANDING).sum()), len(robots)
    drift = alive["displacement"]
    values = (standing / count, *wilson(standing, count), alive["fastest"].max())
    return dict(zip(STOPPED, (*values, drift.mean(), drift.max()), strict=True))


_CONSTANT, _STANDS = "Constant speeds", f"Standing (slower than {STANDING:g} m/s)"
_CASE_COLUMNS = {
    _CONSTANT: ("vx", "vy", "mse_steady", "heading_error"),
    _STANDS: ("standing_rate", "fastest", "drift", "drift_max", "vx", "vy", "mse_steady"),
    "Sideways": ("vy", "vy_error", "vx", "mse_steady"),
}


def _case_tables(frame: pd.DataFrame) -> Iterator[Table]:
    """For each controller constant speeds, standing and sideways, without empty tables."""
    titles = np.where(frame["standing_rate"].isna(), _CONSTANT, _STANDS)
    frame = frame.assign(title=np.where(frame["vy_command"] != 0, "Sideways", titles))
    for (label, mine), (title, columns) in product(
        frame.groupby("label", sort=False), _CASE_COLUMNS.items()
    ):
        shown = {name: QUANTITIES[MEANS.get(name, name)] for name in ("success_rate", *columns)}
        body = []
        for row in mine[mine["title"] == title].to_dict("records"):
            texts = (each.between(row[name], *_ends(row, name)) for name, each in shown.items())
            body.append([row["case"], f"{row['seconds']:g}", *texts])
        heads = ["case", "time [s]", *(each.heading for each in shown.values())]
        if body:
            yield Table(heads, body, f"{title}, {label}")


def _ends(row: Mapping[str, float], name: str) -> list[float]:
    """The interval of a share; NaN for others."""
    prefix = name.removesuffix("_rate")
    return [row.get(f"{prefix}_{end}", np.nan) for end in ("low", "high")]


_KINDS = {
    "speeds": ("Mean speed and commanded speed", _SPEEDS_CAPTION, _speeds, _speed_tables),
    "segments": ("Changing commands", _SEGMENTS_CAPTION, _segments, _segment_tables),
    "cases": ("Cases", _CASES_CAPTION, _cases, _case_tables),
}
"""Kind of protocols → title, caption, frame of evaluations, and tables of the frame."""
