"""Protocols beside that of Table 1: the figure of their report, and its table."""

from collections.abc import Sequence
from typing import Any

from slider.reports.comparison import METRICS, compare, read_rows
from slider.reports.controllers import label, speed
from slider.reports.page import Cell, Section, Table, picture
from slider.reports.protocols.speeds import TRACKED_SHARE, highest_tracked
from slider.reports.sections.sources import Sources
from slider.reports.sections.table1 import comparison_table

_ABOUT = {  # section → title, and what the protocol asks for
    "robust": (
        "Disturbed robots",
        "Noise, delay, pushes, and robots and ground that differ from those of the training.",
    ),
    "sweep": ("Sweep of the commanded speed", "Every command from standing to the fastest."),
    "joystick": ("Changing commands", "Commands as from a joystick, changing on the way."),
}
_SPEEDS = (
    "Mean speed (band: one standard deviation between robots), share of robots that stay up (line) "
    "and that track (dots), and mean squared error, over the commanded speed."
)
_PROFILE = (
    "Commanded (black) and measured velocities and yaw rate: mean and one standard deviation "
    "between the robots that are still up; below, their share."
)
_MEASURES = {
    "vx_error": "error of vx [m/s]",
    "vy_error": "error of vy [m/s]",
    "yaw_rate_error": "error of yaw rate [rad/s]",
    "heading_error": "heading [rad]",
    "touchdown_rate": "touchdowns [1/s]",
    "displacement": "displacement [m]",
}
Row = dict[str, str]


def section(name: str, sources: Sources) -> Section:
    """A protocol of constant commands or of a changing one; its settings tell which."""
    title, what = _ABOUT[name]
    protocol = sources.configuration["protocols"][name]
    rows = read_rows(sources.file(name, f"{name}.csv"))
    changing = "profile" in protocol
    caption = _PROFILE if changing else _SPEEDS
    values = {
        "name": name,
        "what": what,
        "protocol": protocol,
        "picture": picture(sources.file(name, f"{name}.svg"), f"Figure: {title}", caption),
    }
    if changing:
        return Section(title, "profile.html", values | {"tables": _segments(rows)})
    return Section(title, "speeds.html", values | _constant(rows))


def _constant(rows: Sequence[Row]) -> dict[str, Any]:
    """Table 1's tables for this protocol, the speeds themselves, and the highest tracked ones."""
    highest = [
        (label(name), "none" if value is None else f"{speed(value)} m/s")
        for name, value in highest_tracked(rows).items()
    ]
    tables = [comparison_table(compare(rows, metric)) for metric in METRICS]
    return {"tables": [_speeds(rows), *tables], "highest": highest, "share": TRACKED_SHARE}


def _speeds(rows: Sequence[Row]) -> Table:
    """Mean speed and its spread between robots: commands down, controllers across."""
    found = {(row["controller"], float(row["command_velocity"])): row for row in rows}
    controllers = list(dict.fromkeys(row["controller"] for row in rows))
    body = [
        [Cell(speed(command), command), *(_speed(found[name, command]) for name in controllers)]
        for command in sorted({command for _, command in found})
    ]
    return Table(["command [m/s]", *map(label, controllers)], body, "Mean speed [m/s]")


def _speed(row: Row) -> Cell:
    if not row["mean_velocity"]:
        return Cell("–")
    mean, spread = float(row["mean_velocity"]), float(row["mean_velocity_spread"])
    return Cell(f"{round(mean, 3) + 0.0:.3f} ± {spread:.3f}", mean)  # no -0.000


def _segments(rows: Sequence[Row]) -> list[Table]:
    """A table per controller with a row per segment."""
    columns = ["from [s]", "segment", "vx, vy, yaw rate", "up", *_MEASURES.values()]
    return [
        Table(columns, [_segment(row) for row in rows if row["controller"] == name], label(name))
        for name in dict.fromkeys(row["controller"] for row in rows)
    ]


def _segment(row: Row) -> list[Cell]:
    wanted = ", ".join(row[f"{axis}_command"] for axis in ("vx", "vy", "yaw_rate"))
    start, up = float(row["time"]), float(row["success_rate"])
    return [
        Cell(f"{start:g}", start),
        Cell(row["segment"].replace("_", " "), row["segment"]),
        Cell(wanted, wanted),
        Cell(f"{up:.0%}", up),
        *(_number(row[name]) for name in _MEASURES),
    ]


def _number(text: str) -> Cell:
    return Cell(f"{float(text):.3f}", float(text)) if text else Cell("–")
