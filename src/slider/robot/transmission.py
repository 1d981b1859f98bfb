"""Transmission from motors to joints: hip motors drive their joint, leg motors slide and ankle.

Motor angles are ``matrix @ joints``, joint efforts ``matrix.T @ torques`` (virtual work). Leg
motors drive one joint each, or both through a capstan: turning in the same direction they move the
slide, in opposite directions the foot, with angles s/r ± β/n for a slide s [m] and an ankle β
[rad], drum radius r and foot ratio n. Torque limit, torque-speed line, rotor inertia and position
loop belong to motors; their effect on joints follows from the matrix. Without a capstan, the units
of the slide's motor are N, m/s and kg instead of N m, rad/s and kg m².
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np

from slider.config.robot import Capstan, Mechanism
from slider.core.arrays import Array, namespace
from slider.robot.names import GAIT_JOINTS, LEG_GAIT_JOINTS, NUM_JOINTS, SIDES, driven_joints

T = TypeVar("T")


def leg_matrix(capstan: Capstan | None, size: int = LEG_GAIT_JOINTS) -> np.ndarray:
    """Motor angles per joint position (size, size); columns: hip, slide, ankle, ankle roll."""
    matrix = np.eye(size)
    if capstan is None:
        return matrix
    slide, foot = 1.0 / capstan.drum_radius, 1.0 / capstan.foot_ratio
    matrix[3:5, 3:5] = [[slide, foot], [slide, -foot]]
    return matrix


def by_motor(robot: Mechanism, table: Mapping[str, T]) -> list[T]:
    """Entries of a table, by drive name, for each motor of a leg, from the hip down."""
    return [table[name] for name in robot.leg_motors]


def leg_inertia(robot: Mechanism) -> np.ndarray:
    """Matrix of rotor inertia and armature, added to that of a leg's driven joints [kg m², kg]."""
    rotors = np.array([drive.inertia for drive in by_motor(robot, robot.drives)])
    matrix = leg_matrix(robot.capstan, len(rotors))
    names = robot.geometry.leg_joints[: len(rotors)]
    armatures = [robot.joints[name].armature for name in names]
    return matrix.T @ (rotors[:, None] * matrix) + np.diag(armatures)


@dataclass(frozen=True)
class Transmission:
    """The m motors of the robot in the order of ``motor_names``; m is 10, or 12 with soles.

    Attributes:
        matrix: motor angles per joint position (m, 12).
        torque, stall: torque limit and stall torque (m,) [N m].
        speed: no-load speed of the torque-speed line (m,) [rad/s].
        inertia: rotor inertia (m,) [kg m²].
    """

    matrix: Array
    torque: Array
    stall: Array
    speed: Array
    inertia: Array

    @classmethod
    def of(cls, robot: Mechanism) -> "Transmission":
        """The motors of both legs of a robot."""
        motors = by_motor(robot, robot.drives) * len(SIDES)
        matrix, driven = np.zeros((len(motors), NUM_JOINTS)), driven_joints(robot.geometry)
        leg = leg_matrix(robot.capstan, len(motors) // len(SIDES))
        matrix[:, list(driven)] = np.kron(np.eye(len(SIDES)), leg)
        torque, speed, ratio, inertia = (
            np.array([getattr(motor, name) for motor in motors])
            for name in ("torque", "speed", "stall_ratio", "inertia")
        )
        return cls(matrix, torque, ratio * torque, speed, inertia)

    @cached_property
    def inverse(self) -> Array:
        """Motor torques per joint effort (m, 12); passive joints have none."""
        xp = namespace(self.matrix)
        driven = [*GAIT_JOINTS] if len(self.matrix) < NUM_JOINTS else slice(None)
        inverse = xp.zeros_like(self.matrix)
        inverse[:, driven] = xp.linalg.inv(self.matrix[:, driven]).T
        return inverse

    def angles(self, joints: Array) -> Array:
        """Motor angles or speeds (..., m) [rad, rad/s] for joint positions or speeds (..., 12)."""
        return joints @ self.matrix.T

    def torques(self, efforts: Array) -> Array:
        """Motor torques (..., m) [N m] that produce joint efforts (..., 12) [N m or N]."""
        return efforts @ self.inverse.T

    def efforts(self, torques: Array) -> Array:
        """Joint efforts (..., 12) [N m or N] produced by motor torques (..., m) [N m]."""
        return torques @ self.matrix

    def torque_limits(self, speeds: Array) -> tuple[Array, Array]:
        """Minimum and maximum torque (..., m) [N m] at motor speeds (..., m) [rad/s]."""
        upper = (self.stall * (1 - speeds / self.speed)).clip(-self.torque, self.torque)
        lower = (-self.stall * (1 + speeds / self.speed)).clip(-self.torque, self.torque)
        return lower, upper

    def shares(self, efforts: Array, speeds: Array) -> tuple[Array, Array]:
        """Torque / limit and voltage / bus voltage (..., m) for joint efforts and speeds.

        A torque at a speed is feasible if both are within ±1; the voltage share is
        torque / stall torque + speed / no-load speed.
        """
        torques, turning = self.torques(efforts), self.angles(speeds)
        return torques / self.torque, torques / self.stall + turning / self.speed
