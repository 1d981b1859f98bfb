"""Equation 1 of the paper: from the virtual-knee leg to the prismatic leg.

Hip pitch and ankle turn about +y, the knee about −y with flexion θ ≥ 0. ``exact`` is the geometry
of the triangle hip-knee-ankle; ``paper`` is the matrix as printed, kept for comparison: its angles
and velocities are inaccurate, and its velocities are not the derivatives of its positions.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from slider.config.robot import Geometry, Mechanism
from slider.robot.names import GAIT_JOINTS, LEG_GAIT_JOINTS, NUM_JOINTS, mirror_sign

# Pitch is the last hip joint of a robot with a virtual knee.
_PITCH, _KNEE, _ANKLE = (np.s_[..., k::LEG_GAIT_JOINTS] for k in (2, 3, 4))
_SAGITTAL = _PITCH, _ANKLE, _KNEE

Motion = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Positions and their first and second derivatives (..., 10) [rad, m]."""


class Triangle(NamedTuple):
    """Triangle of hip, knee and ankle: terms of eq. 1 and their derivatives by the flexion θ.

    Attributes:
        length: distance from hip to ankle [m].
        shifts: angles of the thigh ahead of that line and of the shank behind it [rad].
        rates: first derivatives of both shifts and of the length.
        curvatures: their second derivatives; the paper states none, so 0 for its variant.
    """

    length: np.ndarray
    shifts: tuple[np.ndarray, np.ndarray]
    rates: tuple[np.ndarray, np.ndarray, np.ndarray]
    curvatures: tuple[np.ndarray | float, ...]


def sides(theta: Any, l1: float, l2: float, xp: Any = np) -> tuple[Any, Any, Any]:
    """Shifts [rad] and length [m] of a ``Triangle``; ``xp``: numpy, or casadi for its symbols."""
    # Separate sines: derivatives of a shared symbol would round differently.
    hip = xp.atan2(l2 * xp.sin(theta), l1 + l2 * xp.cos(theta))
    ankle = xp.atan2(l1 * xp.sin(theta), l2 + l1 * xp.cos(theta))
    return hip, ankle, xp.sqrt(l1**2 + l2**2 + 2 * l1 * l2 * xp.cos(theta))


def triangle(theta: np.ndarray, l1: float, l2: float, variant: str = "exact") -> Triangle:
    """Terms at knee flexions θ [rad] for a thigh l1 and a shank l2 [m]."""
    *shifts, length = sides(theta, l1, l2)
    sine, cosine = np.sin(theta), np.cos(theta)
    if variant == "paper":
        printed = l2 / length * theta, l1 / length * theta
        slopes = l2 / length * cosine, l1 / length * cosine, -2 * l1 * l2 * cosine
        return Triangle(length, printed, slopes, (0.0, 0.0, 0.0))
    hip, ankle = l2 * (l2 + l1 * cosine) / length**2, l1 * (l1 + l2 * cosine) / length**2
    bend = l1 * l2 * sine * (l2**2 - l1**2) / length**4
    slide = -l1 * l2 * (cosine / length + l1 * l2 * sine**2 / length**3)
    rates = hip, ankle, -l1 * l2 * sine / length
    return Triangle(length, (shifts[0], shifts[1]), rates, (bend, -bend, slide))


@dataclass(frozen=True)
class KneeLengths:
    """Thigh, shank and the hip-ankle distance at slide = 0 [m]."""

    thigh: float
    shank: float
    nominal: float

    @classmethod
    def of(cls, robot: Mechanism) -> "KneeLengths | None":
        """The virtual leg of a robot, if it has one."""
        knee = robot.virtual_knee
        if knee is None:
            return None
        return cls(knee.thigh_length, knee.shank_length, robot.geometry.leg_length)


def prismatic_joints(
    q: np.ndarray, v: np.ndarray, robot: Mechanism, variant: str = "exact"
) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities (N, 12) of the prismatic robot for knee legs (N, 10): eq. 1.

    Upper feet do not move; ``slide`` is zero at the nominal leg length. Without a virtual knee, q
    and v are already those of the robot's own joints.
    """
    q, v, _ = prismatic_motion(q, v, 0.0 * v, KneeLengths.of(robot), variant)
    return all_joints(q), all_joints(v)


def prismatic_motion(
    q: np.ndarray,
    v: np.ndarray,
    a: np.ndarray,
    lengths: KneeLengths | None,
    variant: str = "exact",
) -> Motion:
    """Driven prismatic joints (..., 10) for knee legs, with first and second derivatives: eq. 1.

    q̇_p = J q̇_k and q̈_p = J q̈_k + J̇ q̇_k; derivatives by time or any other variable. Without
    ``lengths``, the arguments are returned unchanged.
    """
    if lengths is None:
        return q, v, a
    terms = triangle(q[_KNEE], lengths.thigh, lengths.shank, variant)
    turn = _moved(a, terms.rates, a[_KNEE])
    for index, sign, bend in zip(_SAGITTAL, (-1.0, -1.0, 1.0), terms.curvatures, strict=True):
        turn[index] += sign * bend * v[_KNEE] ** 2
    position, (hip, ankle) = q.copy(), terms.shifts
    position[_PITCH], position[_ANKLE] = q[_PITCH] - hip, q[_ANKLE] - ankle
    position[_KNEE] = terms.length - lengths.nominal
    return position, _moved(v, terms.rates, v[_KNEE]), turn


def _moved(values: np.ndarray, rates: Sequence[np.ndarray], knee: np.ndarray) -> np.ndarray:
    """Right side of eq. 1: J v for joint ``values`` v, whose knee component is ``knee``."""
    hip, ankle, slide = rates
    moved = values.copy()
    moved[_PITCH], moved[_ANKLE] = values[_PITCH] - hip * knee, values[_ANKLE] - ankle * knee
    moved[_KNEE] = slide * knee
    return moved


def all_joints(joints: np.ndarray) -> np.ndarray:
    """Values of all joints (..., 12) from those of gait joints (..., 10); 0 for each leg's last."""
    full = np.zeros((*joints.shape[:-1], NUM_JOINTS))
    full[..., list(GAIT_JOINTS)] = joints
    return full


def reflected(joints: np.ndarray, geometry: Geometry) -> np.ndarray:
    """Gait joints (..., 10) mirrored at the sagittal plane: legs swapped, yaw and roll negated."""
    signs = np.array(mirror_sign(geometry))[:LEG_GAIT_JOINTS]
    first, second = joints[..., :LEG_GAIT_JOINTS], joints[..., LEG_GAIT_JOINTS:]
    return np.concatenate([signs * second, signs * first], axis=-1)
