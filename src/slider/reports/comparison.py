"""Table 1 as people compare it: a table per quantity, commands down, controllers across."""

import math
from collections.abc import Sequence
from dataclasses import replace

from slider.reports.quantities import PAPER, QUANTITIES, decimals, speed_text
from slider.reports.rows import Row
from slider.reports.table import Cell, Table

METRICS = {"success_rate": "success_rate", "mse_steady": "mse", "mse": "mse", "tracking_rate": ""}
"""Column of the table → that of the paper's rows.

The paper does not say whether its MSE has the start in it: it stands beside both of ours.
"""
_COMPARABLE = 0.01  # an error is best only where as many survive as in the best, up to this share


def comparisons(rows: Sequence[Row]) -> list[Table]:
    """All metrics of rows as those of ``table1.csv``."""
    return [compare(rows, name) for name in METRICS]


def compare(rows: Sequence[Row], name: str) -> Table:
    """One metric; measured controllers first, in the order of the rows.

    The best of a line are marked, and all that look the same when printed.
    """
    cells = {(row["source"], row["controller"], row["speed"]): row for row in rows}
    controllers = list(dict.fromkeys((source, controller) for source, controller, _ in cells))
    if not METRICS[name]:
        controllers = [item for item in controllers if item[0] != PAPER]
    commands = sorted({command for source, _, command in cells if source != PAPER})
    body = [
        [Cell(speed_text(v), v), *_marked([cells.get((*one, v)) for one in controllers], name)]
        for v in commands
    ]
    names = {(row["source"], row["controller"]): row["label"] for row in rows}
    heads = ["command [m/s]", *(names[one] for one in controllers)]
    quantity = QUANTITIES[name]
    return Table(heads, body, quantity.title if quantity.share else quantity.heading)


def _marked(rows: Sequence[Row | None], name: str) -> list[Cell]:
    """Errors are those of robots that survived: one is best only among controllers that hardly
    lose more robots than any.
    """
    share = QUANTITIES[name].share
    success = [row["success_rate"] if row else 0.0 for row in rows]
    success = [0.0 if math.isnan(value) else value for value in success]
    enough = 0.0 if share else max(success) - _COMPARABLE
    values = [_value(row, name) for row in rows]
    fair = [v == v and s >= enough for v, s in zip(values, success, strict=True)]
    known = [value for value, one in zip(values, fair, strict=True) if one]
    best = (max if share else min)(known, default=math.nan)
    alone = len(rows) == 1
    return [
        replace(_cell(row, value, name), best=one and not alone and _same(value, best, share))
        for row, value, one in zip(rows, values, fair, strict=True)
    ]


def _value(row: Row | None, name: str) -> float:
    if row is None:
        return math.nan
    return row[METRICS[name] if row["source"] == PAPER else name]


def _cell(row: Row | None, value: float, name: str) -> Cell:
    """Such as ``99.6 % ± 0.5 [99.0, 99.8]`` or ``0.00837 ± 0.00003``."""
    if row is None or math.isnan(value):
        return Cell("–")
    if math.isinf(value):
        return Cell("∞", value)
    share, spread = QUANTITIES[name].share, math.nan
    if row["source"] != PAPER:
        spread = row[f"{name}_std"]
    scale, digits, unit = (100, 1, " %") if share else (1, decimals(value), "")
    text = f"{scale * value:.{digits}f}{unit}"
    if not math.isnan(spread):
        text += f" ± {scale * spread:.{digits}f}"
    if name == "success_rate" and not math.isnan(row["success_low"]):
        text += f" [{100 * row['success_low']:.1f}, {100 * row['success_high']:.1f}]"
    return Cell(text, value)


def _same(value: float, best: float, share: bool) -> bool:
    if not math.isfinite(best):
        return False
    digits = 3 if share else decimals(best)
    return round(value, digits) == round(best, digits)
