"""What a gait minimises. A cost is a sum over the nodes of both steps."""

from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca

from slider.gait.drives import Motors

_SMALL_POWER = 1.0  # rounds the corner of |power| at zero [W]


@dataclass(frozen=True)
class NodeMotion:
    """What a cost may look at.

    Attributes:
        torques: (10,) of the virtual knee's joints [N m].
        motors: of the robot.
        step_time: [s].
        weight: Simpson weight of the node; the weights of a step sum to one.
        robot_weight: m g [N].
    """

    torques: ca.SX
    motors: Motors
    step_time: ca.SX
    weight: ca.SX
    robot_weight: float


@dataclass(frozen=True)
class Cost:
    """A node's part of the cost; ``scale`` brings the sum near one for the solver."""

    node: Callable[[NodeMotion], ca.SX]
    unit: str
    scale: float


def _paper(motion: NodeMotion) -> ca.SX:
    """Eq. 2 as printed: Σ over domains of (1/T) Σ over nodes of ‖τ‖²."""
    return ca.sumsqr(motion.torques) / motion.step_time


def _torque(motion: NodeMotion) -> ca.SX:
    """Σ over domains of (1/T) ∫ ‖τ‖² dt."""
    return motion.weight * ca.sumsqr(motion.torques)


def _transport(motion: NodeMotion) -> ca.SX:
    """Mean absolute mechanical power of the motors over m g: the cost of transport times speed."""
    absolute = ca.sqrt(motion.motors.powers**2 + _SMALL_POWER**2) - _SMALL_POWER
    return motion.weight / 2 * ca.sum1(absolute) / motion.robot_weight


COSTS = {
    "paper": Cost(_paper, "N^2 m^2 / s", 1e-4),
    "torque": Cost(_torque, "N^2 m^2", 1e-3),
    "transport": Cost(_transport, "m/s", 1.0),
}
