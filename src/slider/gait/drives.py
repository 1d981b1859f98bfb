"""Limits of the prismatic leg's drives, on the virtual-knee leg (eq. 1, exact).

Virtual work turns the virtual-knee torques into the efforts of the prismatic leg. The slide's
force is work over |dl/dθ|, which vanishes for a straight leg: the knee's lower bound keeps away
from it. Products with |dl/dθ| instead, without the division, take three times the iterations.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np

from slider.core.config.robot import Capstan, JointLimits
from slider.gait.constraint import Constraint, between
from slider.gait.symbols import NodeSymbols
from slider.gait.tree import LEG_JOINTS
from slider.robot.knee_model import KneeModel

TORQUE_SCALE = 50.0  # [N m]
FORCE_SCALE = 400.0  # [N]
SPEED_SCALE = 10.0  # [rad/s]
KNEE = 3
ROTARY = ("hip_yaw", "hip_roll", "hip_pitch", "ankle")


@dataclass(frozen=True)
class LegDrives:
    """The prismatic leg's drives in terms of the virtual-knee leg.

    Attributes:
        torques: of yaw, roll, pitch and ankle [N m].
        speeds: of yaw, roll, pitch and ankle [rad/s].
        slide_speed: rate of the hip-ankle distance, with the sign of θ's (positive: shorter) [m/s].
        slide_work: slide force · |dl/dθ| [N m].
        slide_arm: |dl/dθ| [m/rad].
        hip_pitch, ankle, length: positions [rad], [rad], [m].
    """

    torques: list[ca.SX]
    speeds: list[ca.SX]
    slide_speed: ca.SX
    slide_work: ca.SX
    slide_arm: ca.SX
    hip_pitch: ca.SX
    ankle: ca.SX
    length: ca.SX

    @property
    def powers(self) -> list[ca.SX]:
        """Mechanical power of the five drives [W]."""
        rotary = [t * v for t, v in zip(self.torques, self.speeds, strict=True)]
        return [*rotary, self.slide_work * self.slide_speed / self.slide_arm]


def leg_drives(s: NodeSymbols, torques: ca.SX, model: KneeModel) -> list[LegDrives]:
    """Drives of the stance and of the swing leg."""
    return [_leg(s, torques, model, leg) for leg in (0, LEG_JOINTS)]


def _leg(s: NodeSymbols, torques: ca.SX, model: KneeModel, leg: int) -> LegDrives:
    l1, l2 = model.thigh, model.shank
    q, v, t = (x[leg : leg + LEG_JOINTS] for x in (s.q, s.v, torques))
    theta, rate = q[KNEE], v[KNEE]
    length = ca.sqrt(l1**2 + l2**2 + 2 * l1 * l2 * ca.cos(theta))
    hip = l2 * (l2 + l1 * ca.cos(theta)) / length**2
    ankle = l1 * (l1 + l2 * ca.cos(theta)) / length**2
    arm = l1 * l2 * ca.sin(theta) / length
    hip_shift = ca.atan2(l2 * ca.sin(theta), l1 + l2 * ca.cos(theta))
    return LegDrives(
        torques=[t[0], t[1], t[2], t[4]],
        speeds=[v[0], v[1], v[2] - hip * rate, v[4] - ankle * rate],
        slide_speed=arm * rate,
        slide_work=t[3] + hip * t[2] + ankle * t[4],
        slide_arm=arm,
        hip_pitch=q[2] - hip_shift,
        ankle=q[4] - (theta - hip_shift),
        length=length,
    )


Limits = dict[str, JointLimits]


def torque(legs: list[LegDrives], limits: Limits) -> Constraint:
    """Torques of the rotary drives."""
    rows = [t for leg in legs for t in leg.torques]
    bound = np.tile([limits[name].effort for name in ROTARY], 2)
    return between("torque", "N m", "robot.limits", rows, -bound, bound, TORQUE_SCALE)


def slide_force(legs: list[LegDrives], limits: Limits) -> Constraint:
    """Force of the slides."""
    rows = [leg.slide_work / leg.slide_arm for leg in legs]
    bound = np.full(len(rows), limits["slide"].effort)
    return between("slide_force", "N", "robot.limits.slide", rows, -bound, bound, FORCE_SCALE)


def capstan(legs: list[LegDrives], drive: Capstan) -> Constraint:
    """Torques of the two equal motors of the differential capstan.

    Same sense moves the slide by ``drum_radius`` per motor angle, opposite sense turns the foot by
    ``foot_ratio``: motor torques are (r F ± n τ_ankle)/2.
    """
    rows = []
    for leg in legs:
        slide = drive.drum_radius * leg.slide_work / leg.slide_arm
        foot = drive.foot_ratio * leg.torques[3]
        rows += [(slide + foot) / 2, (slide - foot) / 2]
    bound = np.full(len(rows), drive.torque)
    return between("capstan", "N m", "robot.capstan.torque", rows, -bound, bound, TORQUE_SCALE)


def speed(legs: list[LegDrives], limits: Limits) -> Constraint:
    """Speeds of the drives."""
    rows = [v for leg in legs for v in (*leg.speeds, leg.slide_speed)]
    bound = np.tile([limits[name].speed for name in (*ROTARY, "slide")], 2)
    return between("speed", "rad/s, m/s", "robot.limits", rows, -bound, bound, SPEED_SCALE)


def position(legs: list[LegDrives], limits: Limits, leg_length: float) -> Constraint:
    """Hip pitch, ankle and slide; yaw and roll are bounded as variables."""
    rows = [p for leg in legs for p in (leg.hip_pitch, leg.ankle, leg.length)]
    pitch, ankle, slide = (limits[name] for name in ("hip_pitch", "ankle", "slide"))
    lower = np.tile([pitch.lower, ankle.lower, leg_length + slide.lower], 2)
    upper = np.tile([pitch.upper, ankle.upper, leg_length + slide.upper], 2)
    return between("position", "rad, m", "robot.limits", rows, lower, upper, 1.0)
