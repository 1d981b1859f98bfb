"""Equation 1 of the paper: from the virtual-knee leg to the prismatic leg.

Hip pitch and ankle turn about +y, the knee about −y with flexion θ ≥ 0. ``exact`` is the geometry
of the triangle hip-knee-ankle; ``paper`` is the matrix as printed, kept for comparison: its angles
and velocities are off, and its velocities are not the derivatives of its positions.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from slider.config.robot import Geometry, Mechanism
from slider.robot.names import ACTUATED, LEG_MOTORS, NUM_JOINTS, mirror_sign

_PITCH, _KNEE, _ANKLE = (np.s_[..., k::LEG_MOTORS] for k in (2, 3, 4))  # pitch is last of the hip

Motion = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Positions and their first and second derivatives (..., 10) [rad, m]."""


class SagittalLeg(NamedTuple):
    """Hip pitch α, leg length l and ankle β of the prismatic leg.

    Positions [rad], [m], [rad]; velocities [rad/s], [m/s], [rad/s]; all of one shape.
    """

    hip_pitch: np.ndarray
    length: np.ndarray
    ankle: np.ndarray


class _Triangle(NamedTuple):
    """Hip, knee and ankle: the terms of eq. 1 and of its derivatives by the flexion θ.

    Attributes:
        length: from hip to ankle [m].
        shifts: angles of the thigh ahead of that line, of the shank behind it [rad].
        rates, curvatures: first and second derivatives of both shifts and of the length.
    """

    length: np.ndarray
    shifts: tuple[np.ndarray, np.ndarray]
    rates: tuple[np.ndarray, np.ndarray, np.ndarray]
    curvatures: tuple[np.ndarray, np.ndarray, np.ndarray]


def _triangle(theta: np.ndarray, l1: float, l2: float) -> _Triangle:
    sine, cosine = np.sin(theta), np.cos(theta)
    length = np.sqrt(l1**2 + l2**2 + 2 * l1 * l2 * cosine)
    shifts = np.arctan2(l2 * sine, l1 + l2 * cosine), np.arctan2(l1 * sine, l2 + l1 * cosine)
    hip, ankle = l2 * (l2 + l1 * cosine) / length**2, l1 * (l1 + l2 * cosine) / length**2
    bend = l1 * l2 * sine * (l2**2 - l1**2) / length**4
    slide = -l1 * l2 * (cosine / length + l1 * l2 * sine**2 / length**3)
    rates = hip, ankle, -l1 * l2 * sine / length
    return _Triangle(length, shifts, rates, (bend, -bend, slide))


def leg_length(theta: np.ndarray, l1: float, l2: float) -> np.ndarray:
    """Hip-ankle distance [m] at knee flexion θ [rad]."""
    return _triangle(theta, l1, l2).length


def positions(
    hip_pitch: np.ndarray,
    theta: np.ndarray,
    ankle: np.ndarray,
    l1: float,
    l2: float,
    variant: str = "exact",
) -> SagittalLeg:
    """Prismatic positions of a knee leg (eq. 1, left)."""
    triangle = _triangle(theta, l1, l2)
    hip_shift, ankle_shift = triangle.shifts
    if variant == "paper":
        hip_shift, ankle_shift = l2 / triangle.length * theta, l1 / triangle.length * theta
    return SagittalLeg(hip_pitch - hip_shift, triangle.length, ankle - ankle_shift)


def rates(
    theta: np.ndarray, l1: float, l2: float, variant: str = "exact"
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Coefficients (a, b, c) of α̇ = α̇' − a θ̇, β̇ = β̇' − b θ̇, l̇ = c θ̇ (eq. 1, right)."""
    triangle = _triangle(theta, l1, l2)
    if variant == "exact":
        return triangle.rates
    length, cosine = triangle.length, np.cos(theta)
    return l2 / length * cosine, l1 / length * cosine, -2 * l1 * l2 * cosine


def velocities(
    hip_pitch_rate: np.ndarray,
    theta: np.ndarray,
    theta_rate: np.ndarray,
    ankle_rate: np.ndarray,
    l1: float,
    l2: float,
    variant: str = "exact",
) -> SagittalLeg:
    """Prismatic velocities of a knee leg (eq. 1, right)."""
    hip, ankle, slide = rates(theta, l1, l2, variant)
    return SagittalLeg(
        hip_pitch_rate - hip * theta_rate, slide * theta_rate, ankle_rate - ankle * theta_rate
    )


def prismatic_joints(
    q: np.ndarray, v: np.ndarray, robot: Mechanism, variant: str = "exact"
) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities (N, 12) of the prismatic robot of knee legs (N, 10): eq. 1.

    Upper feet rest; ``slide`` is zero at the nominal leg length. Without a virtual knee q and v are
    the leg's own.
    """
    if robot.virtual_knee is None:
        return with_upper_feet(q), with_upper_feet(v)
    lengths = robot.virtual_knee.thigh_length, robot.virtual_knee.shank_length
    position, velocity = q.copy(), v.copy()
    place = positions(q[_PITCH], q[_KNEE], q[_ANKLE], *lengths, variant)
    rate = velocities(v[_PITCH], q[_KNEE], v[_KNEE], v[_ANKLE], *lengths, variant)
    position[_PITCH], position[_KNEE], position[_ANKLE] = place
    velocity[_PITCH], velocity[_KNEE], velocity[_ANKLE] = rate
    position[_KNEE] -= robot.geometry.leg_length
    return with_upper_feet(position), with_upper_feet(velocity)


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


def prismatic_motion(
    q: np.ndarray, v: np.ndarray, a: np.ndarray, lengths: KneeLengths | None
) -> Motion:
    """Driven prismatic joints (..., 10) of knee legs, with first and second derivatives: eq. 1.

    q̇_p = J q̇_k and q̈_p = J q̈_k + J̇ q̇_k with the exact geometry; derivatives over time or over
    anything else. Without ``lengths`` the joints are the leg's own.
    """
    if lengths is None:
        return q, v, a
    l1, l2 = lengths.thigh, lengths.shank
    position, rate, turn = q.copy(), v.copy(), a.copy()
    triangle = _triangle(q[_KNEE], l1, l2)
    shifts, slopes, bends = triangle.shifts, triangle.rates, triangle.curvatures
    position[_PITCH], position[_ANKLE] = q[_PITCH] - shifts[0], q[_ANKLE] - shifts[1]
    position[_KNEE] = triangle.length - lengths.nominal
    for index, slope, bend, rigid in (
        (_PITCH, -slopes[0], -bends[0], 1.0),
        (_ANKLE, -slopes[1], -bends[1], 1.0),
        (_KNEE, slopes[2], bends[2], 0.0),
    ):
        rate[index] = rigid * v[index] + slope * v[_KNEE]
        turn[index] = rigid * a[index] + slope * a[_KNEE] + bend * v[_KNEE] ** 2
    return position, rate, turn


def with_upper_feet(joints: np.ndarray) -> np.ndarray:
    """Values of all joints (..., 12) from those of the driven ones (..., 10); upper feet rest."""
    full = np.zeros((*joints.shape[:-1], NUM_JOINTS))
    full[..., list(ACTUATED)] = joints
    return full


def reflected(joints: np.ndarray, geometry: Geometry) -> np.ndarray:
    """Values (..., 10) of the knee legs in the sagittal mirror: swapped, yaw and roll flipped."""
    signs = np.array(mirror_sign(geometry))[:LEG_MOTORS]
    first, second = joints[..., :LEG_MOTORS], joints[..., LEG_MOTORS:]
    return np.concatenate([signs * second, signs * first], axis=-1)
