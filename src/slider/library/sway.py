"""How much the base of a reference gait speeds up and slows down within its steps."""

import numpy as np

from slider.library.blend import blend
from slider.library.contents import LibraryContents

_OUTSIDE = 1e-6  # [m/s]


def forward_variance(library: LibraryContents, vx: float) -> float | None:
    """Variance over time of the forward velocity in the gait at (vx, 0) [m²/s²].

    For comparison, not a bound: the gaits are not optimised for an even speed. Between the
    velocities of the library it is that of the blended gait; outside them there is none.
    """
    axis = library.mesh.vx
    if not axis[0] - _OUTSIDE <= vx <= axis[-1] + _OUTSIDE:
        return None
    gait = blend(library, vx, 0.0)
    speed = gait.forward.reshape(2, -1)
    share = gait.step_time / gait.step_time.sum()
    mean = share @ _mean(speed)
    return float(share @ _mean((speed - mean) ** 2))


def _mean(steps: np.ndarray) -> np.ndarray:
    """Mean over the time of each step (2,), trapezoidal, of samples (2, nodes) even in time."""
    return np.trapezoid(steps, dx=1.0 / (steps.shape[1] - 1), axis=1)
