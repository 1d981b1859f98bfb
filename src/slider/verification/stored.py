"""Gaits as the library stores them, and the continuous motion that their coefficients describe."""

from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.interpolate import BPoly

from slider.library.lookup import open_library
from slider.robot.names import LEG_MIRROR_SIGN, SIDES
from slider.verification.coordinates import LEG

KNEE_MIRROR = np.array(LEG_MIRROR_SIGN[:LEG])


@dataclass(frozen=True)
class StoredGait:
    """One gait of the library; shapes, units and frames: ``docs/reference/gait-library.md``."""

    velocities: np.ndarray
    samples: np.ndarray
    time: np.ndarray
    step_time: np.ndarray
    base: np.ndarray
    contact: np.ndarray
    coefficients: np.ndarray
    roll: np.ndarray
    knee_positions: np.ndarray
    knee_velocities: np.ndarray
    knee_torques: np.ndarray
    efforts: np.ndarray
    ground_wrench: np.ndarray
    swing_foot: np.ndarray
    cost: np.ndarray
    max_violation: np.ndarray
    iterations: np.ndarray

    @property
    def half(self) -> int:
        """Samples per step."""
        return len(self.samples) // 2

    def step_of(self, sample: int) -> int:
        """0 in left stance, 1 in right stance."""
        return sample // self.half

    def time_in_step(self, sample: int) -> float:
        """Time since the last touchdown [s]."""
        return float(self.time[sample] - self.time[self.step_of(sample) * self.half])

    def origin(self, step: int) -> np.ndarray:
        """Middle of the stance foot's line (3,) [m]; the first step's is the world's origin."""
        if step == 0:
            return np.zeros(3)
        return np.append(self.swing_foot[self.half - 1, :2], 0.0)

    @cached_property
    def steps(self) -> "tuple[StepMotion, StepMotion]":
        """The continuous motion of both steps."""
        return step_motion(self, 0), step_motion(self, 1)


@dataclass(frozen=True)
class StepMotion:
    """Joints and stance-foot roll over one step as functions of time, world axes, not reflected.

    Attributes:
        side: the stance foot's.
        duration: [s].
        joints: Bézier polynomials and two derivatives, (10,): left leg, right leg [rad].
        roll: quintic through the nodes' roll, rate and acceleration [rad].
    """

    side: str
    duration: float
    joints: tuple[BPoly, BPoly, BPoly]
    roll: tuple[BPoly, BPoly, BPoly]

    def joints_at(self, time: float | np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Positions, velocities and accelerations (..., 10) [rad, rad/s, rad/s²]."""
        q, v, a = (curve(time) for curve in self.joints)
        return q, v, a

    def roll_at(self, time: float | np.ndarray) -> np.ndarray:
        """Roll, rate and acceleration (..., 3) of the stance foot."""
        return np.stack([curve(time) for curve in self.roll], axis=-1)


def step_motion(gait: StoredGait, step: int) -> StepMotion:
    """The motion of one step; scipy's Bernstein polynomials, not those of the optimisation."""
    duration = float(gait.step_time[step])
    joints, roll = gait.coefficients[step], gait.roll[step]
    if step == 1:  # stored reflected: stance leg first
        joints = np.concatenate(
            [KNEE_MIRROR[:, None] * joints[LEG:], KNEE_MIRROR[:, None] * joints[:LEG]]
        )
        roll = -roll
    curve = BPoly(joints.T[:, None, :], [0.0, duration])
    nodes = np.linspace(0.0, duration, gait.half)
    bend = BPoly.from_derivatives(nodes, roll)
    return StepMotion(SIDES[step], duration, _derivatives(curve), _derivatives(bend))


def _derivatives(curve: BPoly) -> tuple[BPoly, BPoly, BPoly]:
    return curve, curve.derivative(), curve.derivative(2)


def load_gaits(path: Path) -> list[StoredGait]:
    """All gaits of the library at ``path``, in its order.

    Raises:
        UserError: not a gait library, or of another version.
    """
    group = open_library(path)
    names = [item.name for item in fields(StoredGait)]
    arrays = {name: np.asarray(group[name][...]) for name in names}  # type: ignore
    count = len(arrays["velocities"])
    return [StoredGait(**{name: a[i] for name, a in arrays.items()}) for i in range(count)]
