"""Foot placement from step to step, for the replay: what a time-indexed gait lacks to stay up.

The error of the divergent component of motion, c + ċ/ω (Takenaka et al. 2009; Englsberger et al.
2015), grows by exp(ω t) until touchdown; the swing foot goes by a share of what it will be then.
The foot lands level along its heading, and what the last impact left of errors fades out.
"""

from dataclasses import dataclass

import numpy as np

from slider.config.robot import Geometry
from slider.config.verification import RegulatorConfig
from slider.robot import names
from slider.verification.reference import Reference, tilt_of

_PRISMATIC = len(names.LEG_JOINTS)
_HIP = np.array([names.LEG_JOINTS.index("hip_roll"), names.LEG_JOINTS.index("hip_pitch")])


@dataclass(frozen=True)
class Measurement:
    """What the regulator sees, world axes; the robot's state is known exactly in a verification.

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
class Touchdown:
    """What the last touchdown left: errors of the joints (12,) and of the swing foot (3,) [m]."""

    joints: np.ndarray
    swing: np.ndarray


def touchdown(found: Measurement, desired: Reference) -> Touchdown:
    """Errors at the start of a step, to be faded out over it."""
    return Touchdown(found.joints - desired.joints, found.swing - found.stance - desired.swing)


@dataclass(frozen=True)
class Regulator:
    """Joint targets of a step of a gait of forward velocity ``speed`` [m/s]."""

    geometry: Geometry
    config: RegulatorConfig
    speed: float

    def targets(
        self,
        found: Measurement,
        desired: Reference,
        past: Touchdown,
        side: str,
        phase: float,
        left: float,
    ) -> np.ndarray:
        """Joint targets (12,) of a stance ``side`` at a phase, with ``left`` seconds to go."""
        fade = 1.0 - _smooth(phase / self.config.fade)
        targets = desired.joints + fade * past.joints
        self._hold_torso(targets, found, desired, side)
        place = found.stance + desired.swing + fade * past.swing
        place[:2] += _smooth(phase / self.config.placement_end) * self.displacement(
            found, desired, left
        )
        other = names.SIDES[1 - names.SIDES.index(side)]
        start = names.SIDES.index(other) * _PRISMATIC
        targets[start : start + _PRISMATIC - 1] = level_leg(
            self.geometry, other, found.base, place, desired.direction
        )
        return targets

    def _hold_torso(
        self, targets: np.ndarray, found: Measurement, desired: Reference, side: str
    ) -> None:
        """Let the stance hip hold the torso where it should be in the world, not on the leg."""
        error = tilt_of(found.base[1]) - desired.tilt
        hips = names.SIDES.index(side) * _PRISMATIC + _HIP
        targets[hips] = found.joints[hips] + error

    def displacement(self, found: Measurement, desired: Reference, left: float) -> np.ndarray:
        """By how much (2,) [m] the swing foot lands away from the gait's own place."""
        frequency = np.sqrt(names.GRAVITY / desired.com[2])
        place = found.com - found.stance - desired.com
        error = place + (found.com_velocity - desired.com_velocity) / frequency
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
    way from the sole to the hip, so that yaw and roll follow from it in closed form.

    Args:
        geometry: of the robot.
        side: the leg's.
        base: position (3,) [m] and rotation to world (3, 3).
        sole: middle of the foot line (3,) [m].
        heading: unit vector (3,) along the foot line, towards the toe.
    """
    position, rotation = base
    sign = 1.0 if side == names.SIDES[0] else -1.0
    hip = position + rotation @ np.array([0.0, sign * geometry.hip_offset, 0.0])
    axis = _cross(hip - sole, heading)
    axis /= np.linalg.norm(axis)
    ankle = sole + geometry.ankle_height * _cross(heading, axis)
    turn = rotation.T @ axis
    roll = np.arcsin(np.clip(turn[2], -1.0, 1.0))
    yaw = np.arctan2(-turn[0], turn[1])
    to_leg = _about_x(roll).T @ _about_z(yaw).T @ rotation.T
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


def _about_x(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def _about_z(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
