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


def read_row(labels: Mapping[str, str], summary: Mapping[str, Any]) -> Row:
    """The summary of an evaluation."""
    name, error = summary["controller"], summary["mse_steady"]
    error = math.inf if error is None else float(error)
    return Row(labels.get(name, name), float(summary["command"]), summary["success_rate"], error)


def table(rows: Sequence[Row]) -> str:
    """Two lines per controller, a column per command.

    Errors are those of robots that survive, ∞ where none does.
    """
    commands = sorted({row.command for row in rows})
    found = {(row.label, row.command): row for row in rows}
    lines = [("command [m/s]", "", [str(command) for command in commands])]
    for label in dict.fromkeys(row.label for row in rows):
        cells = [found.get((label, command)) for command in commands]
        successes = [f"{100 * row.success:.3g}" if row else "" for row in cells]
        errors = [f"{row.error:.3g}".replace("inf", "∞") if row else "" for row in cells]
        lines += [(label, "success [%]", successes), ("", "MSE [m²/s²]", errors)]
    width = max(len(label) for label, _, _ in lines)
    texts = (
        f"{label:<{width}}  {quantity:<11}" + "".join(f"{cell:>10}" for cell in cells)
        for label, quantity, cells in lines
    )
    return "\n".join(map(str.rstrip, texts))
