"""The readings of the paper, with the value that each has in this run."""

import csv
from collections.abc import Iterator, Mapping
from importlib.resources import files
from typing import Any

from slider.reports.sections.sources import Sources
from slider.reports.table import Cell, Table, Text

FILE = "readings.csv"


def read() -> list[dict[str, str]]:
    """What the paper says, how it is read, and where that is configured."""
    text = (files("slider.reports") / FILE).read_text(encoding="utf-8")
    return list(csv.DictReader(text.splitlines()))


def blocks(sources: Sources) -> Iterator[Text | Table]:
    """One row per reading."""
    yield Text("What the paper leaves open, how it is read here, and where that is configured.")
    rows = [
        [Cell(text, text) for text in reading.values()]
        + [Cell(in_effect(sources.configuration, reading["where"]))]
        for reading in read()
    ]
    yield Table(["the paper says", "we read", "where", "in this run"], rows)


def in_effect(configuration: Mapping[str, Any], path: str) -> str:
    """Value at a dotted path, where it is a single value."""
    node: Any = configuration
    for name in path.split("."):
        if not isinstance(node, Mapping) or name not in node:
            return ""
        node = node[name]
    return "" if isinstance(node, (Mapping, list)) else str(node)
