"""Clock that runs through the two steps of a walk at the pace of the gait library."""

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
        i, a = _cell(self.vx, vx)
        j, b = _cell(self.vy, vy)
        k, m = np.minimum(i + 1, len(self.vx) - 1), np.minimum(j + 1, len(self.vy) - 1)
        table = self.step_time
        near = table[i, j] * (1 - b) + table[i, m] * b
        far = table[k, j] * (1 - b) + table[k, m] * b
        return near * (1 - a) + far * a


def _cell(axis: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Index of the grid value below and the fraction above it."""
    if len(axis) == 1:
        return np.zeros(len(value), dtype=int), np.zeros(len(value))
    position = np.interp(value, axis, np.arange(len(axis)))
    index = np.minimum(position.astype(int), len(axis) - 2)
    return index, position - index


class Clock:
    """Phase in [0, 1) of N walks: left stance below 0.5, right stance from there on."""

    def __init__(self, times: StepTimes, period: float, num_robots: int) -> None:
        self._times = times
        self._period = period
        self.phase = np.zeros(num_robots)

    def advance(self, command: np.ndarray) -> None:
        """Move on by one control period at the step times of the commands (N, ≥ 2)."""
        step_time = self._times.at(command[:, 0], command[:, 1])
        self.phase = (self.phase + self._period / (2.0 * step_time)) % 1.0

    @property
    def left_stance(self) -> np.ndarray:
        """Whether the left foot should carry the robot (N,)."""
        return self.phase < 0.5
