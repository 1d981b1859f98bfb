"""Tables of constant commands: quantities and controllers down, commands across."""

from collections.abc import Sequence
from pathlib import Path

from slider.artefacts.store import Store
from slider.reports.controllers import PAPER, label, speed
from slider.reports.results.markdown import grid, markdown
from slider.reports.results.numbers import NONE, Row, interval, number, percent, read

_TITLES = {
    "success_rate": "success [%]",
    "mse_steady": "MSE from 2 s on [m²/s²]",
    "mse": "MSE over all 10 s [m²/s²]",
    "tracking_rate": "tracking [%]",
}
_PRINTED = "MSE as the paper prints it [m²/s²]"


def table1(report: Path, store: Store) -> str:
    """Success with its interval, both errors and tracking; the paper's own rows below ours."""
    rows = read(report)
    ours = [row for row in rows if row["source"] != PAPER]
    paper = [row for row in rows if row["source"] == PAPER]
    commands = _commands(ours)
    body = _group(rows, "success_rate", commands)
    body += _group(ours, "mse_steady", commands) + _group(ours, "mse", commands)
    body += _group(paper, "mse", commands, _PRINTED) + _group(ours, "tracking_rate", commands)
    return _table(body, commands)


def robust(report: Path, store: Store) -> str:
    """Success with its interval, tracking and settled error of disturbed robots."""
    rows = read(report)
    commands = _commands(rows)
    names = ("success_rate", "tracking_rate", "mse_steady")
    return _table([line for name in names for line in _group(rows, name, commands)], commands)


def _commands(rows: Sequence[Row]) -> list[float]:
    return sorted({float(row["command_velocity"]) for row in rows})


def _table(body: Sequence[Sequence[str]], commands: Sequence[float]) -> str:
    return markdown(grid(["command [m/s]", "", *map(speed, commands)], body))


def _group(
    rows: Sequence[Row], name: str, commands: Sequence[float], title: str = ""
) -> list[list[str]]:
    """A line per controller; the first one has the title of the quantity."""
    lines = []
    for source, controller in dict.fromkeys((row["source"], row["controller"]) for row in rows):
        mine = [row for row in rows if (row["source"], row["controller"]) == (source, controller)]
        cells = {float(row["command_velocity"]): _cell(row, name) for row in mine}
        found = [cells.get(command, NONE) for command in commands]
        head = "" if lines else title or _TITLES[name]
        lines.append([head, label(controller, source), *found])
    return lines


def _cell(row: Row, name: str) -> str:
    if name == "success_rate" and row["success_low"]:
        return interval(row, name, "success_low", "success_high")
    return percent(row[name]) if name in ("success_rate", "tracking_rate") else number(row[name])
