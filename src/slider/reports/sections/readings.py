"""The paper statement by statement, with the value that each has in this run."""

import csv
from collections.abc import Iterator, Mapping
from importlib.resources import files
from typing import Any

from slider.reports.rows import by
from slider.reports.sections.sources import Sources
from slider.reports.table import Cell, Table, Text

FILE = "readings.csv"
HEADS = ("the paper says", "status", "here", "where")


def read() -> list[dict[str, str]]:
    """Each statement: part of the paper, what it says, status, what is here, and where."""
    text = (files("slider.reports") / FILE).read_text(encoding="utf-8")
    return list(csv.DictReader(text.splitlines()))


def blocks(sources: Sources) -> Iterator[Text | Table]:
    """A table per part of the paper, a row per statement."""
    yield Text("What the paper says, whether it is here as printed, and where that is configured.")
    for part, statements in by(read(), "part").items():
        rows = [
            [*(Cell(text, text) for text in list(statement.values())[1:])]
            + [Cell(in_effect(sources.configuration, statement["where"]))]
            for statement in statements
        ]
        yield Table([*HEADS, "in this run"], rows, part)


def in_effect(configuration: Mapping[str, Any], where: str) -> str:
    """Value of the first place, if that is a dotted path to a single value."""
    node: Any = configuration
    for name in where.split(", ")[0].split("."):
        if not isinstance(node, Mapping) or name not in node:
            return ""
        node = node[name]
    return "" if isinstance(node, (Mapping, list)) else str(node)
