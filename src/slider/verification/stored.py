"""Gaits as the library stores them, and the continuous motion that their coefficients describe."""

from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
from scipy.interpolate import BPoly

from slider.config.robot import Geometry
from slider.library.reader import GaitLibrary
from slider.robot.knee_map import reflected
from slider.robot.names import LAST_JOINTS, NUM_JOINTS, SIDES


@dataclass(frozen=True)
class StoredGait:
    """One gait of the library; shapes, units and frames: ``docs/reference/gait-library.md``."""

    geometry: Geometry
    velocities: np.ndarray
    samples: np.ndarray
    time: np.ndarray
    step_time: np.ndarray
    base: np.ndarray
    coefficients: np.ndarray
    roll: np.ndarray
    knee_positions: np.ndarray
    knee_velocities: np.ndarray
    knee_torques: np.ndarray
    efforts: np.ndarray
    ground_wrench: np.ndarray
    swing_foot: np.ndarray

    @property
    def turns(self) -> np.ndarray:
        """Yaw (2,) [rad] of each step's landing foot from its stance foot, as commanded."""
        return self.velocities[2] * self.step_time

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

    def heading(self, step: int) -> float:
        """Yaw of a step's stance foot [rad]; the first step's is the world's x axis."""
        return float(self.turns[:step].sum())

    def origin(self, step: int) -> np.ndarray:
        """Middle of the stance foot's line (3,) [m]; the first step's is the world's origin."""
        if step == 0:
            return np.zeros(3)
        return np.append(self.swing_foot[self.half - 1, :2], 0.0)

    @property
    def last_joints(self) -> np.ndarray:
        """Positions and velocities (S, 2, 2) of both ankles' rolls; zero where a foot is a line."""
        return self.samples[:, : 2 * NUM_JOINTS].reshape(-1, 2, NUM_JOINTS)[..., LAST_JOINTS]

    @cached_property
    def steps(self) -> "list[StepMotion]":
        """The continuous motion of both steps; scipy's Bernstein polynomials."""
        motions = []
        for side, time, legs, roll in zip(
            SIDES, map(float, self.step_time), self.coefficients, self.roll, strict=True
        ):
            if side == SIDES[1]:  # stored reflected: stance leg first
                legs, roll = reflected(legs.T, self.geometry).T, -roll
            joints = BPoly(legs.T[:, None, :], [0.0, time])
            bend = BPoly.from_derivatives(np.linspace(0.0, time, self.half), roll)
            orders = ((x, x.derivative(), x.derivative(2)) for x in (joints, bend))
            motions.append(StepMotion(side, time, *orders))
        return motions


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


def gaits_of(library: GaitLibrary) -> list[StoredGait]:
    """All gaits of a library, in its order."""
    names = [item.name for item in fields(StoredGait) if item.name != "geometry"]
    arrays, geometry = {name: library.arrays[name] for name in names}, library.robot.geometry
    return [
        StoredGait(geometry, **{name: values[i] for name, values in arrays.items()})
        for i in range(len(library))
    ]
