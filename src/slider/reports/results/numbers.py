"""Numbers of a table as people read them."""

import csv
import math
from enum import Enum
from pathlib import Path

from slider.reports.comparison import decimals

NONE = "–"
Row = dict[str, str]


class Kind(Enum):
    """How a quantity is shown: as it is, metres in centimetres, a share in percent."""

    PLAIN = 1.0
    CENTI = 100.0
    SHARE = 0.0


def read(path: Path) -> list[Row]:
    """Rows of a report."""
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def shown(text: str, kind: Kind) -> str:
    """A cell as text; – where it is empty."""
    return percent(text) if kind is Kind.SHARE else number(text, kind.value)


def number(text: str, factor: float = 1.0) -> str:
    """Three digits of a cell times a factor; – where it is empty."""
    if not text:
        return NONE
    value = factor * float(text)
    if not math.isfinite(value):
        return "∞"
    found = f"{value:.{decimals(abs(value))}f}"
    return found if float(found) else "0"


def percent(text: str) -> str:
    """A share in percent with one decimal, without its sign; – where it is empty."""
    return f"{100 * float(text):.1f}".removesuffix(".0") if text else NONE


def interval(row: Row, name: str, low: str, high: str) -> str:
    """A share in percent with its interval, such as ``99.6 [99, 99.8]``."""
    if not row[name]:
        return NONE
    return f"{percent(row[name])} [{percent(row[low])}, {percent(row[high])}]"
