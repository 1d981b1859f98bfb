"""The readings of the paper, with the value that each has in this run."""

import csv
from collections.abc import Mapping
from importlib.resources import files
from typing import Any

from slider.reports.page import Cell, Section, Table
from slider.reports.sections.sources import Sources

FILE = "readings.csv"


def read() -> list[dict[str, str]]:
    """What the paper says, how it is read, and where that is configured."""
    text = (files("slider.reports.sections") / FILE).read_text(encoding="utf-8")
    return list(csv.DictReader(text.splitlines()))


def section(sources: Sources) -> Section:
    """One row per reading."""
    rows = [
        [
            Cell(reading["paper"], reading["paper"]),
            Cell(reading["reading"], reading["reading"]),
            Cell(reading["where"], reading["where"]),
            Cell(_in_effect(sources.configuration, reading["where"])),
        ]
        for reading in read()
    ]
    columns = ["the paper says", "we read", "where", "in this run"]
    return Section("Readings of the paper", "readings.html", {"table": Table(columns, rows)})


def _in_effect(configuration: Mapping[str, Any], path: str) -> str:
    """Value at a dotted path, where it is a single value."""
    node: Any = configuration
    for name in path.split("."):
        if not isinstance(node, Mapping) or name not in node:
            return ""
        node = node[name]
    return "" if isinstance(node, (Mapping, list)) else str(node)
