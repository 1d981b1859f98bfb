"""The linear inverted pendulum (LIP) in closed form; one axis, vectorised.

ẍ = ω² (x − p) with the foot p fixed during a step; Kajita et al., "The 3D linear inverted pendulum
mode", IROS 2001. States are (…, 2): position relative to the foot [m] and velocity [m/s].
"""

import numpy as np

from slider.robot.names import GRAVITY


def rate(height: float) -> float:
    """Natural frequency ω [rad/s] of a pendulum of ``height`` [m]."""
    return float(np.sqrt(GRAVITY / height))


def step_map(omega: float, time: np.ndarray | float) -> np.ndarray:
    """Matrices (…, 2, 2) that move a state on by ``time`` (…) [s] with the foot in place."""
    cosh, sinh = np.cosh(omega * np.asarray(time)), np.sinh(omega * np.asarray(time))
    rows = [[cosh, sinh / omega], [omega * sinh, cosh]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def forward_end_velocity(omega: float, time: float, mean: np.ndarray) -> np.ndarray:
    """Velocity at the end of a step of the orbit with ``mean`` velocity (…) [m/s].

    The orbit goes from −L/2 to L/2 with L = mean · time, so that
    v_end = ω (L/2) / tanh(ω time / 2): faster than the mean.
    """
    return omega * mean * time / 2 / np.tanh(omega * time / 2)


def lateral_end_velocity(omega: float, time: float, width: float) -> float:
    """Speed [m/s] away from the foot at the end of a step of the sideways orbit.

    The orbit starts and ends half of ``width`` [m] beside the foot:
    v = ω (width/2) tanh(ω time / 2).
    """
    return float(omega * width / 2 * np.tanh(omega * time / 2))


def orbital_energy(omega: float, state: np.ndarray) -> np.ndarray:
    """(ẋ/ω)² − x² (…) [m²], constant during a step; negative: the pendulum turns back."""
    return (state[..., 1] / omega) ** 2 - state[..., 0] ** 2
