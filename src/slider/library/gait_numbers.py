"""Numbers of a reference gait that a controller's walk is compared with."""

from typing import NamedTuple

import numpy as np

from slider.library.blend import Gait, blend
from slider.library.reader import GaitLibrary

_OUTSIDE = 1e-6  # [m/s]


class GaitNumbers(NamedTuple):
    """Of one gait.

    Attributes:
        touchdown_rate: of both feet, one per step: 1 / step time [1/s].
        velocity_variance: over time, of the forward velocity [m²/s²].
    """

    touchdown_rate: float
    velocity_variance: float


def gait_numbers(library: GaitLibrary, vx: float) -> GaitNumbers | None:
    """Of the gait at (vx, 0) [m/s].

    For comparison, not a bound: the gaits are not optimised for an even speed. Between the
    velocities of the library they are those of the blended gait; outside them there are none.
    """
    axis = library.mesh.vx
    if not axis[0] - _OUTSIDE <= vx <= axis[-1] + _OUTSIDE:
        return None
    gait = blend(library, vx, 0.0)
    return GaitNumbers(float(1.0 / gait.step_time.mean()), _forward_variance(gait))


def _forward_variance(gait: Gait) -> float:
    speed = gait.forward.reshape(2, -1)
    share = gait.step_time / gait.step_time.sum()
    mean = share @ _mean(speed)
    return float(share @ _mean((speed - mean) ** 2))


def _mean(steps: np.ndarray) -> np.ndarray:
    """Mean over the time of each step (2,), trapezoidal, of samples (2, nodes) even in time."""
    return np.trapezoid(steps, dx=1.0 / (steps.shape[1] - 1), axis=1)
