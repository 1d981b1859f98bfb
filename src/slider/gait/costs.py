"""Costs of a gait: sums over the nodes of both steps."""

from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca

from slider.gait.formulation import Node

_SMALL_POWER = 1.0  # smooths |power| at zero [W]


@dataclass(frozen=True)
class Cost:
    """A cost that ``gait.cost`` selects by name.

    Attributes:
        node: term of a node, from the node and its Simpson weight (a step's weights sum to one).
        unit: of the sum.
        scale: factor that brings the sum near one for the solver.
    """

    node: Callable[[Node, ca.SX], ca.SX]
    unit: str
    scale: float


def _paper(node: Node, _: ca.SX) -> ca.SX:
    """Eq. 2 as read: Σ over both steps of (1/T) Σ over nodes of ‖τ‖², T the step time."""
    return ca.sumsqr(node.dynamics.torques) / node.symbols.step_time


def _transport(node: Node, weight: ca.SX) -> ca.SX:
    """Mean absolute mechanical power of the motors over m g: the cost of transport times speed."""
    power = node.motor_torques * node.motor_speeds
    absolute = ca.sqrt(power**2 + _SMALL_POWER**2) - _SMALL_POWER
    return weight / 2 * ca.sum1(absolute) / node.form.weight


COSTS = {
    "paper": Cost(_paper, "N^2 m^2 / s", 1e-4),
    "transport": Cost(_transport, "m/s", 1.0),
}
