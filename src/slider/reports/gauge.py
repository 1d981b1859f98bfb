"""The stage ``gauge``: the highest level of each controller along each axis, and one number.

The level of an axis is the highest one up to which, at every level, at least the share ``survival``
of all robots passes, over all speeds, seeds and directions. The gauge number of a controller is the
mean of its levels over the axes.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path

import pandas as pd

from slider.core import tables
from slider.core.job import Inputs, Job, Section, Summary
from slider.core.quantities import Quantity
from slider.core.tables import Table
from slider.evaluation.gauge import CSV, words
from slider.reports import report

NUMBER = "gauge number"
_CAPTION = """\
Each level has {trials} seeds × {robots} robots at each of {speeds} m/s, {duration:g} s from rest. A
robot passes if it stays up and covers at least {distance:.0%} of the commanded distance. The level
of an axis is the highest one up to which, at every level, at least {share:.0%} of the robots
pass, over all speeds, seeds and directions of pushes. The gauge number is the mean of the levels.
Above a level that no robot passes none is simulated (–). `gauge_cells.csv` has each speed,
seed and direction.
"""


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write ``gauge.csv``, ``gauge_cells.csv`` and ``gauge.md``."""
    labels, parts = section["labels"], []
    for (controller, axis), folder in zip(section["cells"], inputs["cells"], strict=True):
        names = pd.DataFrame({"controller": [controller], "axis": [axis]})
        parts.append(names.merge(tables.read(folder / CSV), how="cross"))
    cells = pd.concat(parts, ignore_index=True)
    tables.write(cells, out / "gauge_cells.csv")
    frame = gauge_frame(cells, labels, section["survival"])
    protocol = section["protocol"]
    speeds = ", ".join(f"{speed:g}" for speed in protocol["speeds"])
    caption = _CAPTION.format(**protocol | {"speeds": speeds, "share": section["survival"]})
    parts = [caption, *gauge_tables(frame)]
    report.write(out / "gauge", "Gauge", section["robot"], frame, parts)
    numbers = frame[frame["axis"] == NUMBER].set_index("controller")["level"].to_dict()
    return {"rows": len(frame), "gauge": numbers}


def gauge_frame(cells: pd.DataFrame, labels: Mapping[str, str], survival: float) -> pd.DataFrame:
    """A row per controller and axis, and after those of a controller its gauge number.

    ``level`` is the highest one, ``magnitude`` its value as text, ``pass_3`` level 3's pass rate.
    """
    rows = []
    for controller, mine in cells.groupby("controller", sort=False):
        about, levels = {"controller": controller, "label": labels[str(controller)]}, []
        for axis, tested in mine.groupby("axis", sort=False):
            counts = tested.groupby("level")[["passed", "robots"]].sum(min_count=1)
            rates = counts["passed"] / counts["robots"]
            level = int((rates >= survival).cumprod().sum())  # up to the first that is below
            value = tested["value"][tested["level"] == level]
            row = about | {"axis": axis, "level": level}
            row["magnitude"] = words(str(axis), value.iloc[0]) if level else ""
            rows.append(row | {f"pass_{number}": rate for number, rate in rates.items()})
            levels.append(level)
        mean = sum(levels) / len(levels)
        rows.append(about | {"axis": NUMBER, "level": mean, "magnitude": ""})
    return pd.DataFrame(rows)


def gauge_tables(frame: pd.DataFrame) -> Iterator[Table]:
    """Levels of all controllers, and the pass rates of each."""
    names = [name for name in frame if name.startswith("pass_")]
    tested, passed = frame["axis"] != NUMBER, Quantity("robots that pass", "%", 100.0, ".0f")
    texts = [_level(row) for row in frame.to_dict("records")]
    frame = frame.assign(axis=frame["axis"].str.replace("_", " "), text=texts)
    body = [[axis, *mine["text"]] for axis, mine in frame.groupby("axis", sort=False)]
    yield Table(["axis", *frame["label"].unique()], body)
    heads = ["robots that pass [%] at level", *(name.removeprefix("pass_") for name in names)]
    for label, mine in frame[tested].groupby("label", sort=False):
        lines = mine[["axis", *names]].itertuples(index=False)
        yield Table(heads, [[axis, *map(passed.text, line)] for axis, *line in lines], str(label))


def _level(row: Mapping[str, object]) -> str:
    """Level and magnitude."""
    if row["axis"] == NUMBER:
        return f"**{row['level']:.1f}**"
    return f"{row['level']:g} ({row['magnitude']})" if row["level"] else "0"
