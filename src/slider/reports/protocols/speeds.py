"""The report of a protocol of constant forward velocities, such as the sweep."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from slider.core.job import Inputs, Job, Section, Summary
from slider.evaluation import records
from slider.reports.controllers import label, speed
from slider.reports.figures.publication import write_pictures
from slider.reports.figures.speed_tracking import draw
from slider.reports.rows import Row, quality_row, read_evaluation, table_row, write_rows

TRACKED_SHARE = 0.9  # of the robots that must track a command for it to count as tracked
_TITLE = "# Mean speed over the commanded speed: {name}"
_CAPTION = """\
{trials} trials of {robots} robots per controller and command, {duration:g} s from rest. What is
drawn counts from {steady:g} s on: mean forward speed (band: one standard deviation between
robots), share of robots that stay up (line) and that track (dots: mean speed within
max({tolerance:g} m/s, {relative:.0%}) of the command), and mean squared error. Speeds and errors
are those of robots that stay up. `reports/{name}.csv` has all numbers, and how the robots walk.

A speed counts as tracked where at least {share:.0%} of the robots track it.
"""


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write ``NAME.csv``, ``NAME.md``, ``NAME.svg`` and ``NAME.png``."""
    name = section["name"]
    rows = [row(*read_evaluation(folder)) for folder in inputs["evaluations"]]
    write_rows(rows, tuple(rows[0]), out / f"{name}.csv")
    write_pictures(out / name, lambda: draw(rows))
    highest = highest_tracked(rows)
    (out / f"{name}.md").write_text(_text(section, highest), encoding="utf-8")
    job.tracker.log_file(out / f"{name}.png")
    known = {f"highest_tracked/{c}": value for c, value in highest.items() if value is not None}
    job.tracker.log_metrics(known, 0)
    return {"rows": len(rows), "highest_tracked": highest}


def row(controller: str, command: float, table: records.Records) -> Row:
    """A row of Table 1 and how the robots walk, with the spread of the mean speed over robots."""
    speeds = table["mean_velocity"][table["survived"]]
    between = {"mean_velocity_spread": float(speeds.std()) if len(speeds) else ""}
    return table_row(controller, command, table) | quality_row(controller, command, table) | between


def highest_tracked(rows: Sequence[Mapping[str, str | float]]) -> dict[str, float | None]:
    """Highest commanded speed [m/s] that each controller tracks; None where it tracks none."""
    found: dict[str, float | None] = {}
    for controller in dict.fromkeys(str(row["controller"]) for row in rows):
        mine = [row for row in rows if row["controller"] == controller]
        tracked = [r for r in mine if float(r["tracking_rate"]) >= TRACKED_SHARE]
        speeds = [float(r["command_velocity"]) for r in tracked]
        found[controller] = float(np.max(speeds)) if speeds else None
    return found


def _text(section: Section, highest: dict[str, float | None]) -> str:
    protocol, name = section["evaluation"], section["name"]
    caption = _CAPTION.format(
        name=name,
        trials=protocol["trials"],
        robots=protocol["robots"],
        duration=protocol["duration"],
        steady=protocol["warm_up"],
        tolerance=protocol["tracking_tolerance"],
        relative=protocol["tracking_relative"],
        share=TRACKED_SHARE,
    )
    lines = [_TITLE.format(name=name), "", f"![{name}](figures/{name}.png)", "", caption]
    lines += ["| controller | highest tracked speed [m/s] |", "|---|---|"]
    for controller, value in highest.items():
        lines.append(f"| {label(controller)} | {'none' if value is None else speed(value)} |")
    return "\n".join([*lines, ""])
