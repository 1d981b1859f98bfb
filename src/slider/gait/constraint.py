"""Named rows of the nonlinear programme, with bounds in SI units."""

from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca
import numpy as np

# (n,), or for rows of a node a function of the phases (S,) that gives (S, n).
Bound = np.ndarray | Callable[[np.ndarray], np.ndarray]
Rows = ca.SX | list[ca.SX]


@dataclass(frozen=True)
class RowInfo:
    """What is known of a named group of rows without its expression.

    Attributes:
        name, unit, source: for reports.
        scale: what the solver divides by.
        size: number of rows.
    """

    name: str
    unit: str
    source: str
    scale: float
    size: int


@dataclass(frozen=True)
class Constraint:
    """A named group of symbolic rows ``expression`` (n,) with bounds, in SI units.

    ``node_lower``: lower bound at the nodes, where it leaves a margin for what happens between.
    """

    name: str
    unit: str
    source: str
    expression: ca.SX
    lower: Bound
    upper: Bound
    scale: float
    node_lower: Bound | None = None

    @property
    def info(self) -> RowInfo:
        """Names and sizes."""
        return RowInfo(self.name, self.unit, self.source, self.scale, self.expression.numel())

    def bounds(self, phase: np.ndarray, at_nodes: bool = True) -> tuple[np.ndarray, np.ndarray]:
        """Scaled bounds (S, n) at phases (S,), with the margin of nodes or without."""
        lower = self.node_lower if at_nodes and self.node_lower is not None else self.lower
        return self._scaled(lower, phase), self._scaled(self.upper, phase)

    def _scaled(self, bound: Bound, phase: np.ndarray) -> np.ndarray:
        values = bound(phase) if callable(bound) else bound
        return np.broadcast_to(values, (len(phase), self.expression.numel())) / self.scale


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
    name: str, unit: str, source: str, rows: Rows, lower: Bound, upper: Bound, scale: float
) -> Constraint:
    """Rows bounded on both sides."""
    return Constraint(name, unit, source, _stack(rows), lower, upper, scale)


def _stack(rows: Rows) -> ca.SX:
    return ca.vertcat(*rows) if isinstance(rows, list) else rows
