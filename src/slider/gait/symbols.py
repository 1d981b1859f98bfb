"""Variables of a node and of the ends of a step."""

from dataclasses import dataclass

import casadi as ca

from slider.gait.tree import LEG_JOINTS, NUM_JOINTS
from slider.robot.names import LEG_MIRROR_SIGN


@dataclass(frozen=True)
class NodeSymbols:
    """Variables of one node: roll of the stance foot, joints over normalised time, step time."""

    roll: ca.SX
    roll_rate: ca.SX
    roll_acceleration: ca.SX
    q: ca.SX
    q_phase: ca.SX
    q_phase2: ca.SX
    step_time: ca.SX

    SIZE = 3 + 3 * NUM_JOINTS + 1

    @classmethod
    def of(cls, x: ca.SX) -> "NodeSymbols":
        """Split a node vector (34,)."""
        n = NUM_JOINTS
        return cls(
            x[0], x[1], x[2], x[3 : 3 + n], x[3 + n : 3 + 2 * n], x[3 + 2 * n : 3 + 3 * n], x[-1]
        )

    @property
    def v(self) -> ca.SX:
        """Joint velocities (10,) [rad/s]."""
        return self.q_phase / self.step_time

    @property
    def a(self) -> ca.SX:
        """Joint accelerations (10,) [rad/s²]."""
        return self.q_phase2 / self.step_time**2


@dataclass(frozen=True)
class StepEnd:
    """State at the start or the end of a step."""

    roll: ca.SX
    roll_rate: ca.SX
    q: ca.SX
    v: ca.SX


def mirrored(q: ca.SX) -> ca.SX:
    """Joint vector (10,) as the next step sees it: legs swapped and reflected."""
    sign = ca.DM(LEG_MIRROR_SIGN[:LEG_JOINTS])
    return ca.SX(ca.vertcat(sign * q[LEG_JOINTS:], sign * q[:LEG_JOINTS]))
