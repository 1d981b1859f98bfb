"""Success and error of controllers in a few lines for the terminal."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple


class Row(NamedTuple):
    """One controller at one command [m/s]: success 0 to 1, MSE after the warm-up [m²/s²]."""

    label: str
    command: float
    success: float
    error: float


def read_row(labels: Mapping[str, str], summary: Mapping[str, Any]) -> Row | None:
    """The summary of an evaluation, or nothing where it is that of something else."""
    if not {"controller", "command", "success_rate"} <= summary.keys():
        return None
    name, error = summary["controller"], summary.get("mse_steady")
    error = math.inf if error is None else float(error)
    return Row(labels.get(name, name), float(summary["command"]), summary["success_rate"], error)


def table(rows: Sequence[Row]) -> str:
    """Two lines per controller, a column per command.

    Errors are those of robots that survive, ∞ where none does.
    """
    commands = sorted({row.command for row in rows})
    found = {(row.label, row.command): row for row in rows}
    labels = list(dict.fromkeys(row.label for row in rows))
    width = max(len(label) for label in labels)
    lines = [_line("command [m/s]", "", width, [str(command) for command in commands])]
    for label in labels:
        cells = [found.get((label, command)) for command in commands]
        successes = ["" if row is None else f"{100 * row.success:.3g}" for row in cells]
        errors = ["" if row is None else _error(row.error) for row in cells]
        lines.append(_line(label, "success [%]", width, successes))
        lines.append(_line("", "MSE [m²/s²]", width, errors))
    return "\n".join(lines)


def _line(label: str, quantity: str, width: int, cells: Sequence[str]) -> str:
    width = max(width, len("command [m/s]"))
    text = f"{label:<{width}}  {quantity:<11}" + "".join(f"{cell:>10}" for cell in cells)
    return text.rstrip()


def _error(value: float) -> str:
    return f"{value:.3g}" if math.isfinite(value) else "∞"
