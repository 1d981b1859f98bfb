"""Held-out commands: constant speeds, standing, sideways, a table each."""

from collections.abc import Callable, Sequence
from pathlib import Path

from slider.artefacts.store import Store
from slider.reports.controllers import label
from slider.reports.protocols.cases import STANDING
from slider.reports.results.markdown import grid, markdown
from slider.reports.results.numbers import Row, interval, number, read

_SURVIVED = ("success_rate", "success_low", "success_high")
_STANDING = ("standing_rate", "standing_low", "standing_high")


def heldout(report: Path, store: Store) -> str:
    """Three tables per controller, without those that have no case."""
    rows = read(report)
    tables = []
    for controller in dict.fromkeys(row["controller"] for row in rows):
        mine = [row for row in rows if row["controller"] == controller]
        for title, chosen, columns in _KINDS:
            cases = [row for row in mine if chosen(row)]
            if cases:
                tables.append(_table(f"{title}, {label(controller)}", cases, columns))
    return "\n\n".join(tables)


def _table(
    title: str, rows: Sequence[Row], columns: Sequence[tuple[str, Callable[[Row], str]]]
) -> str:
    heads = ["case", "time [s]", "survived [%]", *(head for head, _ in columns)]
    body = [
        [row["case"], f"{float(row['seconds']):g}", interval(row, *_SURVIVED)]
        + [text(row) for _, text in columns]
        for row in rows
    ]
    return markdown(grid(heads, body, title))


def _of(column: str) -> Callable[[Row], str]:
    return lambda row: number(row[column])


def _stands(row: Row) -> bool:
    return row["standing_rate"] != ""


def _sideways(row: Row) -> bool:
    return float(row["vy_command"]) != 0


_MEAN, _MSE = ("mean vx [m/s]", _of("vx")), ("MSE of vx [m²/s²]", _of("mse_steady"))
_HEADING = ("largest heading error [rad]", _of("heading_error"))
_KINDS = (  # title, which cases, their columns beside those of all
    (
        "Constant speeds",
        lambda row: not _stands(row) and not _sideways(row),
        (_MEAN, _MSE, _HEADING),
    ),
    (
        f"Standing (slower than {STANDING:g} m/s)",
        _stands,
        (
            ("standing [%]", lambda row: interval(row, *_STANDING)),
            ("fastest robot [m/s]", _of("fastest")),
            ("drift, mean [m]", _of("drift")),
            ("drift, greatest [m]", _of("drift_max")),
        ),
    ),
    (
        "Sideways",
        _sideways,
        (("mean vy [m/s]", _of("vy")), ("error of vy [m/s]", _of("vy_error")), _MEAN, _MSE),
    ),
)
