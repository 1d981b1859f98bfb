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
from slider.verification.leg import level_leg
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


def touchdown(found: Measurement, wanted: Reference) -> Touchdown:
    """Errors at the start of a step, to be faded out over it."""
    return Touchdown(found.joints - wanted.joints, found.swing - found.stance - wanted.swing)


@dataclass(frozen=True)
class Regulator:
    """Joint targets of a step of a gait of forward velocity ``speed`` [m/s]."""

    geometry: Geometry
    config: RegulatorConfig
    speed: float

    def targets(
        self,
        found: Measurement,
        wanted: Reference,
        past: Touchdown,
        side: str,
        phase: float,
        left: float,
    ) -> np.ndarray:
        """Joint targets (12,) of a stance ``side`` at a phase, with ``left`` seconds to go."""
        fade = 1.0 - _smooth(phase / self.config.fade)
        targets = wanted.joints + fade * past.joints
        self._hold_torso(targets, found, wanted, side)
        place = found.stance + wanted.swing + fade * past.swing
        place[:2] += _smooth(phase / self.config.settle) * self.displacement(found, wanted, left)
        other = names.SIDES[1 - names.SIDES.index(side)]
        start = names.SIDES.index(other) * _PRISMATIC
        targets[start : start + _PRISMATIC - 1] = level_leg(
            self.geometry, other, found.base, place, wanted.direction
        )
        return targets

    def _hold_torso(
        self, targets: np.ndarray, found: Measurement, wanted: Reference, side: str
    ) -> None:
        """Let the stance hip hold the torso where it should be in the world, not on the leg."""
        error = tilt_of(found.base[1]) - wanted.tilt
        hips = names.SIDES.index(side) * _PRISMATIC + _HIP
        targets[hips] = found.joints[hips] + error

    def displacement(self, found: Measurement, wanted: Reference, left: float) -> np.ndarray:
        """By how much (2,) [m] the swing foot lands away from the gait's own place."""
        frequency = np.sqrt(names.GRAVITY / wanted.com[2])
        place = found.com - found.stance - wanted.com
        error = place + (found.com_velocity - wanted.com_velocity) / frequency
        forward = np.interp(self.speed, self.config.speeds, self.config.forward)
        share = np.array([forward, self.config.lateral])
        grown = share * error[:2] * np.exp(frequency * max(left, 0.0))
        return np.clip(grown, -self.config.reach, self.config.reach)


def _smooth(x: float) -> float:
    """From 0 to 1 with zero slope at both ends."""
    x = min(max(x, 0.0), 1.0)
    return x * x * (3.0 - 2.0 * x)
