"""The real leg's motors (capstan included), as expressions of joint efforts and joint speeds.

Torque limit and torque-speed line belong to motors. The slide's force is work over |dl/dθ|, which
vanishes for a straight leg: the knee's lower bound keeps away from it.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np

from slider.config.robot import Capstan, Drive
from slider.robot.names import SIDES
from slider.robot.transmission import by_motor, leg_matrix


@dataclass(frozen=True)
class Motors:
    """Both legs' motors: stance, then swing, in the order of ``LEG_MOTORS``.

    Attributes:
        torques: (10,) [N m]; speeds: (10,) [rad/s].
    """

    torques: ca.SX
    speeds: ca.SX

    @classmethod
    def of(cls, efforts: ca.SX, speeds: ca.SX, capstan: Capstan) -> "Motors":
        """Of joint efforts and joint speeds (10,) of the prismatic legs."""
        matrix = np.kron(np.eye(len(SIDES)), leg_matrix(capstan))
        return cls(ca.DM(np.linalg.inv(matrix).T) @ efforts, ca.DM(matrix) @ speeds)

    @property
    def powers(self) -> ca.SX:
        """Mechanical power (10,) [W]."""
        return self.torques * self.speeds

    def torque_shares(self, drives: dict[str, Drive]) -> ca.SX:
        """Torques (10,) as shares of their limits [-]."""
        return self.torques / ca.DM([drive.torque for drive in _both(drives)])

    def voltage_shares(self, drives: dict[str, Drive]) -> ca.SX:
        """Torque / stall torque + speed / no-load speed (10,): shares of the bus [-]."""
        stall = ca.DM([drive.stall_ratio * drive.torque for drive in _both(drives)])
        free = ca.DM([drive.speed for drive in _both(drives)])
        return self.torques / stall + self.speeds / free


def _both(drives: dict[str, Drive]) -> list[Drive]:
    return by_motor(drives) * len(SIDES)
