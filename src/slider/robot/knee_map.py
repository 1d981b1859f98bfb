"""Equation 1 of the paper: from the virtual-knee leg to the prismatic leg.

Hip pitch and ankle turn about +y, the knee about −y with flexion θ ≥ 0. ``exact`` is the geometry
of the triangle hip-knee-ankle; ``paper`` is the matrix as printed, kept for comparison: its angles
and velocities are off, and its velocities are not the derivatives of its positions.
"""

from dataclasses import dataclass

import numpy as np

VARIANTS = ("exact", "paper")


@dataclass(frozen=True)
class SagittalLeg:
    """Hip pitch α, leg length l and ankle β of the prismatic leg.

    Positions [rad], [m], [rad]; velocities [rad/s], [m/s], [rad/s]; all of one shape.
    """

    hip_pitch: np.ndarray
    length: np.ndarray
    ankle: np.ndarray


def leg_length(theta: np.ndarray, l1: float, l2: float) -> np.ndarray:
    """Hip-ankle distance [m] at knee flexion θ [rad]."""
    return np.sqrt(l1**2 + l2**2 + 2 * l1 * l2 * np.cos(theta))


def positions(
    hip_pitch: np.ndarray,
    theta: np.ndarray,
    ankle: np.ndarray,
    l1: float,
    l2: float,
    variant: str = "exact",
) -> SagittalLeg:
    """Prismatic positions of a knee leg (eq. 1, left).

    Raises:
        ValueError: an unknown variant.
    """
    length = leg_length(theta, l1, l2)
    if variant == "exact":
        hip_shift = np.arctan2(l2 * np.sin(theta), l1 + l2 * np.cos(theta))
        ankle_shift = np.arctan2(l1 * np.sin(theta), l2 + l1 * np.cos(theta))
    elif variant == "paper":
        hip_shift, ankle_shift = l2 / length * theta, l1 / length * theta
    else:
        raise ValueError(f"expected one of {VARIANTS}, found {variant}")
    return SagittalLeg(hip_pitch - hip_shift, length, ankle - ankle_shift)


def rates(
    theta: np.ndarray, l1: float, l2: float, variant: str = "exact"
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Coefficients (a, b, c) of α̇ = α̇' − a θ̇, β̇ = β̇' − b θ̇, l̇ = c θ̇ (eq. 1, right).

    Raises:
        ValueError: an unknown variant.
    """
    length = leg_length(theta, l1, l2)
    cosine = np.cos(theta)
    if variant == "exact":
        hip = l2 * (l2 + l1 * cosine) / length**2
        ankle = l1 * (l1 + l2 * cosine) / length**2
        return hip, ankle, -l1 * l2 * np.sin(theta) / length
    if variant == "paper":
        return l2 / length * cosine, l1 / length * cosine, -2 * l1 * l2 * cosine
    raise ValueError(f"expected one of {VARIANTS}, found {variant}")


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


def slide_force(
    knee_torque: np.ndarray,
    hip_torque: np.ndarray,
    ankle_torque: np.ndarray,
    theta: np.ndarray,
    l1: float,
    l2: float,
) -> np.ndarray:
    """Slide force [N] that does the work of the three torques [N m] (virtual work, exact map).

    Hip and ankle torques are the same in both models.
    """
    hip, ankle, slide = rates(theta, l1, l2)
    return (knee_torque + hip * hip_torque + ankle * ankle_torque) / slide
