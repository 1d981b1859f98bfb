"""Table 1: ours, the baselines' and the paper's side by side, and how it walks."""

import csv
from pathlib import Path

from slider.reports.comparison import METRICS, Comparison, Value, compare, read_rows, show
from slider.reports.controllers import label, speed
from slider.reports.page import Cell, Section, Table
from slider.reports.sections.sources import Sources

_QUALITY = {
    "mean_velocity": "mean velocity [m/s]",
    "flight": "flight share",
    "double_support": "double support share",
    "touchdown_rate": "touchdowns [1/s]",
    "alternation": "alternating steps share",
    "clearance": "clearance [m]",
    "slip": "foot slip [m/s]",
    "heading": "heading drift [rad]",
    "asymmetry": "step time asymmetry",
    "velocity_variance": "speed ripple [m²/s²]",
    "reference_velocity_variance": "that of the gait [m²/s²]",
    "cost_of_transport": "cost of transport",
    "peak_effort": "peak effort / limit",
    "peak_speed": "peak speed / limit",
}


def section(sources: Sources) -> Section:
    """One table per metric, and one about the gait's quality."""
    rows = read_rows(sources.file("table1", "table1.csv"))
    tables = [_table(compare(rows, metric)) for metric in METRICS]
    quality = _quality(sources.file("table1", "gait_quality.csv"))
    protocol = sources.configuration["evaluation"]
    values = {"tables": tables, "quality": quality, "protocol": protocol}
    return Section("Table 1", "table1.html", values)


def _table(table: Comparison) -> Table:
    rows = [
        [Cell(speed(command), command), *(_cell(value, table) for value in row)]
        for command, row in zip(table.commands, table.rows, strict=True)
    ]
    return Table(["command [m/s]", *table.controllers], rows, table.metric.title)


def _cell(value: Value | None, table: Comparison) -> Cell:
    text = show(value, table.metric)
    return Cell(text) if value is None else Cell(text, value.value, value.best)


def _quality(path: Path) -> Table:
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    names = [name for name in rows[0] if name not in ("controller", "command_velocity")]
    heads = ["controller", "command [m/s]", *(_QUALITY.get(name, name) for name in names)]
    body = [
        [
            Cell(label(row["controller"]), row["controller"]),
            Cell(speed(float(row["command_velocity"])), float(row["command_velocity"])),
            *(Cell(f"{float(row[n]):.3g}", float(row[n])) if row[n] else Cell("–") for n in names),
        ]
        for row in rows
    ]
    return Table(heads, body, "How it walks: means over surviving robots")
