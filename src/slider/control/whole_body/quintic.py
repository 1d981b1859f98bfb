"""Fifth-order polynomials between two states (position, velocity, acceleration), vectorised."""

import numpy as np


def follow(
    start: np.ndarray, end: np.ndarray, duration: np.ndarray, time: np.ndarray | float
) -> np.ndarray:
    """State at ``time`` of the quintic that joins two states.

    Args:
        start: (…, 3) position, velocity and acceleration at 0.
        end: (…, 3) the same at ``duration``.
        duration: (…), positive [s].
        time: (…), between 0 and ``duration`` [s].

    Returns:
        (…, 3).
    """
    t = np.asarray(time)
    p0, v0, a0 = np.moveaxis(start, -1, 0)
    gap = end[..., 0] - p0 - v0 * duration - 0.5 * a0 * duration**2
    dv = (end[..., 1] - v0 - a0 * duration) * duration
    da = (end[..., 2] - a0) * duration**2
    c3 = (10 * gap - 4 * dv + 0.5 * da) / duration**3
    c4 = (-15 * gap + 7 * dv - da) / duration**4
    c5 = (6 * gap - 3 * dv + 0.5 * da) / duration**5
    position = p0 + t * (v0 + t * (0.5 * a0 + t * (c3 + t * (c4 + t * c5))))
    velocity = v0 + t * (a0 + t * (3 * c3 + t * (4 * c4 + t * 5 * c5)))
    acceleration = a0 + t * (6 * c3 + t * (12 * c4 + t * 20 * c5))
    return np.stack([position, velocity, acceleration], axis=-1)
