"""Limits of the real leg: its motors (capstan included), joint ranges, legs that stay apart.

Torque limit and torque-speed line belong to motors. The slide's force is work over |dl/dθ|, which
vanishes for a straight leg: the knee's lower bound keeps away from it.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np

from slider.config.robot import Capstan, Drive, Joint
from slider.gait.constraint import Constraint, between
from slider.gait.leg_map import LegMap
from slider.gait.symbols import NodeSymbols
from slider.gait.tree import NUM_JOINTS
from slider.robot.names import LEG_JOINTS, LEG_MOTORS, SIDES
from slider.robot.transmission import by_motor, leg_matrix

_BOUNDED = LEG_JOINTS[2 : len(LEG_MOTORS)]  # yaw and roll are bounded as variables


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


def torque(motors: Motors, drives: dict[str, Drive]) -> Constraint:
    """Torques of the motors as shares of their limits."""
    limit = ca.DM([drive.torque for drive in _both(drives)])
    bound = np.ones(NUM_JOINTS)
    return between("motor_torque", "-", "robot.drives", motors.torques / limit, -bound, bound, 1.0)


def voltage(motors: Motors, drives: dict[str, Drive], most: float) -> Constraint:
    """Torque-speed lines: torque / stall torque + speed / no-load speed, the share of the bus.

    ``most``: the share that a gait may use.
    """
    stall = ca.DM([drive.stall_ratio * drive.torque for drive in _both(drives)])
    free = ca.DM([drive.speed for drive in _both(drives)])
    share = motors.torques / stall + motors.speeds / free
    bound = np.full(NUM_JOINTS, most)
    return between("motor_voltage", "-", "gait.voltage", share, -bound, bound, 1.0)


def _both(drives: dict[str, Drive]) -> list[Drive]:
    return by_motor(drives) * len(SIDES)


def position(s: NodeSymbols, leg_map: LegMap, joints: dict[str, Joint]) -> Constraint:
    """Hip pitch, slide and ankle; yaw and roll are bounded as variables."""
    legs = ca.vertsplit(leg_map.positions(s.q), len(LEG_MOTORS))
    rows = [leg[2:] for leg in legs]
    lower = np.tile([joints[name].lower for name in _BOUNDED], len(SIDES))
    upper = np.tile([joints[name].upper for name in _BOUNDED], len(SIDES))
    return between("position", "rad, m", "robot.joints", rows, lower, upper, 1.0)
