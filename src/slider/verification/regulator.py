"""Foot placement from step to step, for the replay: what a time-indexed gait lacks to stay up.

The error of the divergent component of motion, c + ċ/ω (Takenaka et al. 2009; Englsberger et al.
2015), grows by exp(ω t) until touchdown; the swing foot goes by a share of what it will be then.
The foot lands level along its heading, and what the last impact left of errors fades out.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from slider.config.robot import Geometry
from slider.config.verification import RegulatorConfig
from slider.robot import names
from slider.robot.kinematics import about_x, about_z

_PRISMATIC = len(names.LEG_JOINTS)
_HIP_ITERATIONS, _CLOSE = 200, 1e-13  # at most; [rad]
_HIP = np.array([names.LEG_JOINTS.index("hip_roll"), names.LEG_JOINTS.index("hip_pitch")])


class Reference(NamedTuple):
    """A point of a step on the prismatic robot, relative to the stance foot, world axes.

    Attributes:
        joints, velocities, efforts: (12,).
        com, com_velocity: centre of mass (3,) [m] and its velocity [m/s].
        swing, direction: sole of the swing foot (3,) [m] and direction of its line.
        tilt: sines of the base's roll and pitch (2,).
    """

    joints: np.ndarray
    velocities: np.ndarray
    efforts: np.ndarray
    com: np.ndarray
    com_velocity: np.ndarray
    swing: np.ndarray
    direction: np.ndarray
    tilt: np.ndarray


class Measurement(NamedTuple):
    """State that the regulator receives, world axes; in a verification it is exact.

    Attributes:
        base: position (3,) [m] and rotation to world (3, 3).
        joints: (12,) [rad, m].
        com, com_velocity: of the whole robot (3,) [m], [m/s].
        stance, swing: soles (3,) [m].
    """

    base: tuple[np.ndarray, np.ndarray]
    joints: np.ndarray
    com: np.ndarray
    com_velocity: np.ndarray
    stance: np.ndarray
    swing: np.ndarray


@dataclass(frozen=True)
class Regulator:
    """Joint targets of a step of a gait of forward velocity ``speed`` [m/s]."""

    geometry: Geometry
    config: RegulatorConfig
    speed: float

    def targets(
        self,
        measured: Measurement,
        desired: Reference,
        past: tuple[np.ndarray, np.ndarray],
        side: str,
        phase: float,
        left: float,
    ) -> np.ndarray:
        """Joint targets (12,) of a stance ``side`` at a phase, with ``left`` seconds to go.

        ``past`` are the errors of joints (12,) and swing foot (3,) [m] just after the touchdown.
        The stance hip holds the torso where it should be in the world, not on the leg.
        """
        fade = 1.0 - _smooth(phase / self.config.fade)
        targets = desired.joints + fade * past[0]
        hips = names.SIDES.index(side) * _PRISMATIC + _HIP
        targets[hips] = measured.joints[hips] + (tilt_of(measured.base[1]) - desired.tilt)
        place = measured.stance + desired.swing + fade * past[1]
        place[:2] += _smooth(phase / self.config.placement_end) * self._displacement(
            measured, desired, left
        )
        other = names.other_side(side)
        start = names.SIDES.index(other) * _PRISMATIC
        targets[start : start + _PRISMATIC - 1] = level_leg(
            self.geometry, other, measured.base, place, desired.direction
        )
        return targets

    def _displacement(self, measured: Measurement, desired: Reference, left: float) -> np.ndarray:
        """By how much (2,) [m] the swing foot lands away from the gait's own place."""
        frequency = np.sqrt(names.GRAVITY / desired.com[2])
        place = measured.com - measured.stance - desired.com
        error = place + (measured.com_velocity - desired.com_velocity) / frequency
        forward = np.interp(self.speed, self.config.speeds, self.config.forward)
        share = np.array([forward, self.config.lateral])
        grown = share * error[:2] * np.exp(frequency * max(left, 0.0))
        return np.clip(grown, -self.config.reach, self.config.reach)


def _smooth(x: float) -> float:
    """From 0 to 1 with zero slope at both ends."""
    x = min(max(x, 0.0), 1.0)
    return x * x * (3.0 - 2.0 * x)


def level_leg(
    geometry: Geometry,
    side: str,
    base: tuple[np.ndarray, np.ndarray],
    sole: np.ndarray,
    heading: np.ndarray,
) -> np.ndarray:
    """Hip yaw, roll and pitch [rad], slide [m], ankle [rad] (5,) of a foot line along a heading.

    The leg turns pitch and ankle about one axis; it is perpendicular to the foot line and to the
    way from the sole to the pitch axis, so that yaw and roll follow from it in closed form where
    the axes of the hip meet. Where they do not, yaw and roll move the pitch axis: iterated.

    Args:
        geometry: of the robot.
        side: the leg's.
        base: position (3,) [m] and rotation to world (3, 3).
        sole: middle of the foot line (3,) [m].
        heading: unit vector (3,) along the foot line, towards the toe.
    """
    position, rotation = base
    mirror = np.array([1.0, 1.0 if side == names.SIDES[0] else -1.0, 1.0])
    axes, yaw, roll = geometry.axes, 0.0, 0.0
    fixed, moved, turned = (
        mirror * place for place in (axes.hip_yaw, axes.hip_roll, axes.hip_pitch)
    )
    for _ in range(_HIP_ITERATIONS):
        before = np.array([yaw, roll])
        by_yaw, by_roll = about_z(np.array([yaw]))[0], about_x(np.array([roll]))[0]
        hip = position + rotation @ (fixed + by_yaw @ (moved + by_roll @ turned))
        axis = _cross(hip - sole, heading)
        axis /= np.linalg.norm(axis)
        turn = rotation.T @ axis
        roll = np.arcsin(np.clip(turn[2], -1.0, 1.0))
        yaw = np.arctan2(-turn[0], turn[1])
        if np.abs(before - [yaw, roll]).max() < _CLOSE or not (moved.any() or turned.any()):
            break
    ankle = sole + geometry.ankle_height * _cross(heading, axis)
    to_leg = about_x(np.array([roll]))[0].T @ about_z(np.array([yaw]))[0].T @ rotation.T
    reach, toe = to_leg @ (ankle - hip), to_leg @ heading
    pitch = np.arctan2(-reach[0], -reach[2])
    level = np.arctan2(-toe[2], toe[0])
    slide = np.linalg.norm(reach) - geometry.leg_length
    return np.array([yaw, roll, pitch, slide, level - pitch])


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """np.cross for two vectors (3,), which it does ten times slower."""
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def tilt_of(rotation: np.ndarray) -> np.ndarray:
    """Sines of roll and pitch (2,) of a rotation (3, 3) to world."""
    return np.array([rotation[2, 1], -rotation[2, 0]])
