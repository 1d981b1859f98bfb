"""Step time as a function of the commanded velocity."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class StepTimes:
    """Step time over a regular grid of commanded velocities.

    Attributes:
        vx, vy: increasing grid values [m/s], (nx,), (ny,).
        step_time: (nx, ny) [s].
    """

    vx: np.ndarray
    vy: np.ndarray
    step_time: np.ndarray

    def at(self, vx: np.ndarray, vy: np.ndarray) -> np.ndarray:
        """Bilinear step times (N,) [s]; commands outside the grid use its border."""
        i, a = cell(self.vx, vx)
        j, b = cell(self.vy, vy)
        k, m = np.minimum(i + 1, len(self.vx) - 1), np.minimum(j + 1, len(self.vy) - 1)
        table = self.step_time
        near = table[i, j] * (1 - b) + table[i, m] * b
        far = table[k, j] * (1 - b) + table[k, m] * b
        return near * (1 - a) + far * a


def cell(axis: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Index (N,) of the grid value below and the fraction (N,) above it; clamped outside."""
    if len(axis) == 1:
        return np.zeros(len(value), dtype=int), np.zeros(len(value))
    position = np.interp(value, axis, np.arange(len(axis)))
    index = np.minimum(position.astype(int), len(axis) - 2)
    return index, position - index
