"""Reference of the swing foot: quintics, re-planned at every tick from the reference itself.

Forward and sideways: to the planned foothold, at rest there. Up: to the apex at half of the step's
time, then down to the ground with a touchdown velocity; past the step's time it sinks on.
"""

import numpy as np

from slider.config.control import SwingConfig
from slider.control.whole_body.quintic import follow


def begin(position: np.ndarray) -> np.ndarray:
    """Reference (n, 3, 3) at rest at ``position`` (n, 3) [m]."""
    reference = np.zeros((*position.shape, 3))
    reference[:, :, 0] = position
    return reference


def advance(
    reference: np.ndarray,
    target: np.ndarray,
    elapsed: np.ndarray,
    duration: np.ndarray,
    ground: np.ndarray,
    apex: float,
    config: SwingConfig,
    period: float,
) -> np.ndarray:
    """Reference one tick later.

    Args:
        reference: (n, 3, 3) coordinate; position, velocity, acceleration.
        target: foothold (n, 2) [m].
        elapsed, duration: of the step (n,) [s].
        ground: height of the sole on the ground (n,) [m].
        apex: largest height above it [m].
        config: touchdown.
        period: of a tick [s].
    """
    result = np.empty_like(reference)
    left = duration - elapsed
    time = np.maximum(left, 2 * period)
    goal = np.zeros((len(target), 2, 3))
    goal[:, :, 0] = target
    result[:, :2] = follow(reference[:, :2], goal, time[:, None], period)
    rising = elapsed < duration / 2 - 2 * period
    height = np.zeros((len(target), 3))
    height[:, 0] = ground + np.where(rising, apex, 0.0)
    height[:, 1] = np.where(rising, 0.0, -config.touchdown_velocity)
    time = np.where(rising, np.maximum(duration / 2 - elapsed, 2 * period), time)
    result[:, 2] = follow(reference[:, 2], height, time, period)
    late = left < period / 2
    result[late] = begin(reference[late, :, 0])
    result[late, 2, 0] -= config.search_velocity * period
    result[late, 2, 1] = -config.search_velocity
    return result
