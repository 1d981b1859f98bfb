"""Step time as a function of the commanded velocity."""

from dataclasses import dataclass

import numpy as np

from slider.library.mesh import corners


@dataclass(frozen=True)
class StepTimes:
    """Step time over a grid of commanded velocities.

    Attributes:
        vx, vy: increasing grid values [m/s], (nx,), (ny,).
        step_time: (nx, ny) [s].
    """

    vx: np.ndarray
    vy: np.ndarray
    step_time: np.ndarray

    @classmethod
    def constant(cls, step_time: float) -> "StepTimes":
        """The same step time [s] at every velocity."""
        return cls(np.zeros(1), np.zeros(1), np.full((1, 1), step_time))

    def at(self, vx: np.ndarray, vy: np.ndarray) -> np.ndarray:
        """Bilinear step times (N,) [s]; commands outside the grid use its border."""
        result = np.zeros(len(vx))
        for i, j, weight in corners(self.vx, self.vy, vx, vy):
            result += weight * self.step_time[i, j]
        return result
