"""The stage ``gauge``: the highest level of each controller along each axis, and one number.

The level of an axis is the highest one up to which, at every level, at least the share ``survival``
of all robots passes, over all speeds, seeds and directions. The gauge number of a controller is the
mean of its levels over the axes.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path

from slider.core.job import Inputs, Job, Section, Summary
from slider.core.tables import Table
from slider.evaluation.gauge import CSV, words
from slider.reports import rows as tables
from slider.reports.document import picture, write_document
from slider.reports.figures.gauge import draw, pass_rate
from slider.reports.figures.style import write_pictures
from slider.reports.quantities import NONE
from slider.reports.rows import Row, by

NUMBER = "gauge number"
_CAPTION = """\
Each level has {trials} seeds × {robots} robots at each of {speeds} m/s, {duration:g} s from rest. A
robot passes if it stays up and covers at least {distance:.0%} of the commanded distance. The level
of an axis is the highest one up to which, at every level, at least {share:.0%} of the robots
pass, over all speeds, seeds and directions of pushes. The gauge number is the mean of the levels.
Above: levels of each axis. Below: share of robots that pass, by direction in which the robot is
pushed (forward is up, left is left) and impulse [N s]; grey was not simulated.

Above a level that no robot passes none is simulated (–). `gauge_cells.csv` has each speed,
seed and direction.
"""


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write ``gauge.csv``, ``gauge_cells.csv``, ``gauge.md`` and ``gauge.svg``."""
    cells = [
        {"controller": controller, "axis": axis} | row
        for (controller, axis), folder in zip(section["cells"], inputs["cells"], strict=True)
        for row in tables.read(folder / CSV)
    ]
    tables.write(cells, out / "gauge_cells.csv")
    rows = gauge_rows(cells, section["labels"], section["survival"])
    tables.write(rows, out / "gauge.csv")
    write_pictures(out / "gauge", partial(draw, rows, cells, section["labels"]))
    protocol = section["protocol"]
    speeds = ", ".join(f"{speed:g}" for speed in protocol["speeds"])
    caption = _CAPTION.format(**protocol | {"speeds": speeds, "share": section["survival"]})
    parts = [picture("gauge"), caption, *(table.markdown for table in gauge_tables(rows))]
    write_document(out / "gauge.md", "Gauge", section["robot"], parts)
    numbers = {row["controller"]: row["level"] for row in rows if row["axis"] == NUMBER}
    job.log_metrics({f"gauge/{name}": value for name, value in numbers.items()}, 0)
    return {"rows": len(rows), "gauge": numbers}


def gauge_rows(cells: Sequence[Row], labels: Mapping[str, str], survival: float) -> list[Row]:
    """A row per controller and axis, and after those of a controller its gauge number.

    ``level`` is the highest one, ``magnitude`` what it is, ``pass_3`` the pass rate of level 3.
    """
    rows: list[Row] = []
    for controller, mine in by(cells, "controller").items():
        about, levels = {"controller": controller, "label": labels[controller]}, []
        for axis, tested in by(mine, "axis").items():
            groups = list(by(tested, "level").values())
            rates = [pass_rate(group) for group in groups]
            level = highest_level(rates, survival)
            magnitude = words(axis, groups[level - 1][0]["value"]) if level else ""
            values = {f"pass_{number}": rate for number, rate in enumerate(rates, 1)}
            rows.append(about | {"axis": axis, "level": level, "magnitude": magnitude} | values)
            levels.append(level)
        mean = sum(levels) / len(levels)
        rows.append(about | {"axis": NUMBER, "level": mean, "magnitude": ""})
    return rows


def highest_level(rates: Sequence[float], survival: float) -> int:
    """Highest level, counted from 1, up to which no pass rate is below ``survival``; 0: none."""
    below = (index for index, rate in enumerate(rates) if not rate >= survival)
    return next(below, len(rates))


def gauge_tables(rows: Sequence[Row]) -> Iterator[Table]:
    """Levels of all controllers, and the pass rates of each."""
    body = [[_title(axis), *map(_level, mine)] for axis, mine in by(rows, "axis").items()]
    yield Table(["axis", *by(rows, "label")], body)
    names = [name for name in rows[0] if name.startswith("pass_")]
    heads = ["robots that pass [%] at level", *(name.removeprefix("pass_") for name in names)]
    for label, mine in by(rows, "label").items():
        body = [
            [_title(row["axis"])]
            + [NONE if math.isnan(row[name]) else f"{100 * row[name]:.0f}" for name in names]
            for row in mine
            if row["axis"] != NUMBER
        ]
        yield Table(heads, body, label)


def _title(axis: str) -> str:
    return axis.replace("_", " ")


def _level(row: Row) -> str:
    """Level and magnitude."""
    if row["axis"] == NUMBER:
        return f"**{row['level']:.1f}**"
    return f"{row['level']:g} ({row['magnitude']})" if row["level"] else "0"
