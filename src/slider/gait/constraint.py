"""Named rows of the nonlinear programme, with bounds in SI units."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

# One for all rows, or (n,), or for rows of a node a function of the phases (S,) that gives (S, n).
Bound = float | np.ndarray | Callable[[np.ndarray], np.ndarray]
Rows = ca.SX | list[ca.SX]


@dataclass(frozen=True)
class Constraint:
    """A named group of symbolic rows with bounds, in SI units.

    Attributes:
        name: under which residuals are reported.
        unit, source: of the rows; what asks for the bounds: physics, or keys of the configuration.
        expression: (n,).
        lower, upper: bounds.
        scale: what the solver divides by.
        node_lower: lower bound at the nodes, where it leaves a margin for what happens between.
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
    def size(self) -> int:
        """Number of rows."""
        return self.expression.numel()

    def bounds(self, phase: np.ndarray, at_nodes: bool = True) -> tuple[np.ndarray, np.ndarray]:
        """Scaled bounds (S, n) at phases (S,), with the margin of nodes or without."""
        lower = self.node_lower if at_nodes and self.node_lower is not None else self.lower
        return self._scaled(lower, phase), self._scaled(self.upper, phase)

    def _scaled(self, bound: Bound, phase: np.ndarray) -> np.ndarray:
        values = bound(phase) if callable(bound) else bound
        return np.broadcast_to(values, (len(phase), self.size)) / self.scale


def equality(name: str, unit: str, source: str, rows: Rows, scale: float) -> Constraint:
    """Rows that are zero."""
    return between(name, unit, source, rows, 0.0, 0.0, scale)


def at_least(
    name: str, unit: str, source: str, rows: Rows, least: float, scale: float = 1.0
) -> Constraint:
    """Rows bounded below."""
    return between(name, unit, source, rows, least, np.inf, scale)


def within(name: str, unit: str, source: str, rows: Rows, bound: float | np.ndarray) -> Constraint:
    """Rows of no more than a magnitude."""
    return between(name, unit, source, rows, -bound, bound)


def between(
    name: str,
    unit: str,
    source: str,
    rows: Rows,
    lower: Bound,
    upper: Bound,
    scale: float = 1.0,
    node_lower: Bound | None = None,
) -> Constraint:
    """Rows bounded on both sides."""
    expression = ca.vertcat(*rows) if isinstance(rows, list) else rows
    return Constraint(name, unit, source, expression, lower, upper, scale, node_lower)


def scaled_rows(constraints: Sequence[Constraint]) -> ca.SX:
    """All rows as the solver has them."""
    return ca.vertcat(*[c.expression / c.scale for c in constraints])


def scaled_bounds(
    constraints: Sequence[Constraint], phase: np.ndarray, at_nodes: bool = True
) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper bounds (S, rows) of all rows at phases (S,); see ``Constraint.bounds``."""
    lower, upper = zip(*(c.bounds(phase, at_nodes) for c in constraints), strict=True)
    return np.concatenate(lower, axis=1), np.concatenate(upper, axis=1)
