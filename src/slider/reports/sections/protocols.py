"""Protocols beside that of Table 1: the figure of their report, and its table."""

from collections.abc import Callable, Sequence
from typing import Any

from slider.evaluation.segments import SMOOTHING
from slider.reports.comparison import METRICS, compare, read_rows
from slider.reports.controllers import label, speed
from slider.reports.page import Cell, Section, Table, picture
from slider.reports.protocols.cases import COLUMNS, STANDING, cell
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
    "heldout": (
        "Held-out commands",
        "Speeds between those that checkpoints are chosen by, a minute of each, stops, sideways.",
    ),
}
_SPEEDS = (
    "Mean speed (band: one standard deviation between robots), share of robots that stay up (line) "
    "and that track (dots), and mean squared error, over the commanded speed."
)
_PROFILE = (
    "Commanded (black) and measured velocities and yaw rate: mean and one standard deviation "
    "between the robots that are still up; below, their share."
)
_CASES = (
    "Share of robots that survive the case (dot) and that stand after it (ring), with Wilson's "
    "95 % interval; errors of the mean velocity, and the fastest robot after a stop (diamond)."
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
    """A protocol of constant commands, of segments or of cases; its settings tell which."""
    title, what = _ABOUT[name]
    protocol = sources.configuration["protocols"][name]
    rows = read_rows(sources.file(name, f"{name}.csv"))
    shown, tables, caption = _KINDS[protocol["profile"]["rows"] if "profile" in protocol else ""]
    values = {
        "name": name,
        "what": what,
        "protocol": protocol,
        "picture": picture(sources.file(name, f"{name}.svg"), f"Figure: {title}", caption),
    }
    return Section(title, shown, values | tables(rows))


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


def _segments(rows: Sequence[Row]) -> dict[str, Any]:
    """A table per controller with a row per segment."""
    columns = ["from [s]", "segment", "vx, vy, yaw rate", "up", *_MEASURES.values()]
    return {"tables": _by_controller(columns, rows, _segment)}


def _cases(rows: Sequence[Row]) -> dict[str, Any]:
    """A table per controller with a row per case."""
    columns = ["case", *COLUMNS.values()]
    return {
        "tables": _by_controller(columns, rows, _case),
        "settled": f"{STANDING:g} m/s",
        "smoothing": f"{SMOOTHING:g} s",
    }


def _by_controller(
    columns: Sequence[str], rows: Sequence[Row], cells: Callable[[Row], list[Cell]]
) -> list[Table]:
    return [
        Table(columns, [cells(row) for row in rows if row["controller"] == name], label(name))
        for name in dict.fromkeys(row["controller"] for row in rows)
    ]


def _case(row: Row) -> list[Cell]:
    numbers = [Cell(cell(row, name), float(row[name]) if row[name] else "") for name in COLUMNS]
    return [Cell(row["case"], row["case"]), *numbers]


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


# Rows of the protocol's table, nothing for those of constant commands → template, tables, caption.
_KINDS: dict[str, tuple[str, Callable[[Sequence[Row]], dict[str, Any]], str]] = {
    "": ("speeds.html", _constant, _SPEEDS),
    "segments": ("segments.html", _segments, _PROFILE),
    "cases": ("cases.html", _cases, _CASES),
}
