"""Named rows of the nonlinear programme, with bounds in SI units."""

from dataclasses import dataclass

import casadi as ca
import numpy as np


@dataclass(frozen=True)
class Constraint:
    """A named group of expressions with bounds, in SI units.

    Attributes:
        name, unit, source: for reports.
        expression: (n,) symbolic.
        lower, upper: (n,); for node constraints (nodes, n) when they vary over the step.
        scale: what the solver divides by.
    """

    name: str
    unit: str
    source: str
    expression: ca.SX
    lower: np.ndarray
    upper: np.ndarray
    scale: float

    @property
    def size(self) -> int:
        """Number of rows."""
        return self.expression.numel()


Rows = ca.SX | list[ca.SX]


def equality(name: str, unit: str, source: str, rows: Rows, scale: float) -> Constraint:
    """Rows that are zero."""
    expression = _stack(rows)
    zero = np.zeros(expression.numel())
    return Constraint(name, unit, source, expression, zero, zero, scale)


def at_least(
    name: str, unit: str, source: str, rows: Rows, least: float, scale: float
) -> Constraint:
    """Rows bounded below."""
    expression = _stack(rows)
    n = expression.numel()
    return Constraint(name, unit, source, expression, np.full(n, least), np.full(n, np.inf), scale)


def between(
    name: str,
    unit: str,
    source: str,
    rows: Rows,
    lower: np.ndarray,
    upper: np.ndarray,
    scale: float,
) -> Constraint:
    """Rows bounded on both sides (n,) each."""
    return Constraint(name, unit, source, _stack(rows), lower, upper, scale)


def _stack(rows: Rows) -> ca.SX:
    return ca.vertcat(*rows) if isinstance(rows, list) else rows
