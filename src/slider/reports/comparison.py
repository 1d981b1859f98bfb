"""Table 1 as people compare it: one row per command, one column per controller."""

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from slider.reports.controllers import PAPER, label

_COMPARABLE = 0.01  # an error is best only where as many survive as in the best, up to this share
_MOST_DECIMALS = 6  # a robot that stands still has errors of 1e-10 m²/s²


@dataclass(frozen=True)
class Metric:
    """A column of Table 1.

    Attributes:
        name: of the column; the spread is in ``<name>_std``.
        title: heading, with its unit.
        higher_is_better: or lower.
        percent: whether it is shown in percent.
        paper_column: what the paper printed under this heading, or empty.
        interval: columns with the ends of its 95 % interval, or nothing.
    """

    name: str
    title: str
    higher_is_better: bool
    percent: bool
    paper_column: str
    interval: tuple[str, str] | None = None


METRICS = (
    Metric(
        "success_rate",
        "Success rate",
        True,
        True,
        "success_rate",
        ("success_low", "success_high"),
    ),
    # The paper does not say whether its MSE has the start in it: it stands beside both of ours.
    Metric("mse_steady", "Velocity MSE from 2 s on [m²/s²]", False, False, "mse"),
    Metric(
        "mse", "Velocity MSE over all 10 s, start from rest included [m²/s²]", False, False, "mse"
    ),
    Metric("tracking_rate", "Tracking rate", True, True, ""),
)


@dataclass(frozen=True)
class Value:
    """One cell: a number, its spread over trials (NaN if not stated), whether none is better.

    ``interval`` are the ends of its 95 % interval, where it has one.
    """

    value: float
    spread: float
    best: bool
    interval: tuple[float, float] | None = None


@dataclass(frozen=True)
class Comparison:
    """A metric for all commands (rows) and controllers (columns); None where there is no value."""

    metric: Metric
    commands: tuple[float, ...]
    controllers: tuple[str, ...]
    rows: tuple[tuple[Value | None, ...], ...]


def read_rows(path: Path) -> list[dict[str, str]]:
    """Rows of ``table1.csv``."""
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def compare(rows: Sequence[dict[str, str]], metric: Metric) -> Comparison:
    """Put controllers side by side: measured ones first, in the order of the table."""
    columns = list(dict.fromkeys((row["source"], row["controller"]) for row in rows))
    if not metric.paper_column:
        columns = [column for column in columns if column[0] != PAPER]
    ours = {float(row["command_velocity"]) for row in rows if row["source"] != PAPER}
    cells = {
        (row["source"], row["controller"], float(row["command_velocity"])): row for row in rows
    }
    commands = tuple(sorted(ours))
    table = tuple(_marked([cells.get((*c, v)) for c in columns], metric) for v in commands)
    names = tuple(label(controller, source) for source, controller in columns)
    return Comparison(metric, commands, names, table)


def show(value: Value | None, metric: Metric) -> str:
    """Text of a cell, such as ``99.6 % ± 0.5 [99.0, 99.8]`` or ``0.00837 ± 0.00003``."""
    if value is None:
        return "–"
    if math.isinf(value.value):
        return "∞"
    if metric.percent:
        text, spread = f"{100 * value.value:.1f} %", f"{100 * value.spread:.1f}"
    else:
        digits = decimals(value.value)
        text, spread = f"{value.value:.{digits}f}", f"{value.spread:.{digits}f}"
    if not math.isnan(value.spread):
        text = f"{text} ± {spread}"
    if value.interval is None:
        return text
    low, high = (f"{100 * end:.1f}" for end in value.interval)
    return f"{text} [{low}, {high}]"


def _value(row: dict[str, str] | None, metric: Metric) -> Value | None:
    """Not yet marked."""
    if row is None:
        return None
    paper = row["source"] == PAPER
    text = row[metric.paper_column] if paper and metric.paper_column else row[metric.name]
    if not text:
        return None
    spread = "" if paper else row[f"{metric.name}_std"]
    ends = [float(row[name]) for name in metric.interval or () if row[name]]
    interval = (ends[0], ends[1]) if ends else None
    return Value(float(text), float(spread) if spread else math.nan, False, interval)


def _marked(cells: list[dict[str, str] | None], metric: Metric) -> tuple[Value | None, ...]:
    """Mark the best of a row, and all that look the same when printed.

    Errors are those of robots that survived: one is best only among controllers that hardly
    lose more robots than any.
    """
    success = [float(cell["success_rate"] or 0) if cell else 0.0 for cell in cells]
    enough = 0.0 if metric.higher_is_better else max(success) - _COMPARABLE
    values = [_value(cell, metric) for cell in cells]
    fair = [v is not None and share >= enough for v, share in zip(values, success, strict=True)]
    known = [value.value for value, one in zip(values, fair, strict=True) if value and one]
    best = (max if metric.higher_is_better else min)(known, default=math.nan)
    return tuple(
        None if value is None else replace(value, best=one and _same(value.value, best, metric))
        for value, one in zip(values, fair, strict=True)
    )


def _same(value: float, best: float, metric: Metric) -> bool:
    if not math.isfinite(best):
        return False
    digits = 3 if metric.percent else decimals(best)
    return round(value, digits) == round(best, digits)


def decimals(value: float) -> int:
    """Decimals that show three digits of a value, as the paper does, unless it is next to none."""
    if value <= 0:
        return 3
    return min(max(0, 2 - math.floor(math.log10(value))), _MOST_DECIMALS)
