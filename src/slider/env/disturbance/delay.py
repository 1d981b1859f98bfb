"""Delay between a controller's output and the drives, the same for positions and torques."""

import numpy as np

from slider.config.types import Interval


class DelayLine:
    """Inputs of N robots, each later by its own whole number of simulation steps."""

    def __init__(self, delay: Interval, timestep: float, count: int, width: int) -> None:
        self._lower, self._upper = round(delay.lower / timestep), round(delay.upper / timestep)
        self.steps = np.full(count, self._lower)
        self._past = np.zeros((count, self._upper, width))

    def draw(self, index: np.ndarray, uniform: np.ndarray) -> None:
        """New delays of robots ``index`` from numbers (N,) in [0, 1)."""
        choices = self._upper - self._lower + 1
        self.steps[index] = self._lower + np.floor(choices * uniform[index]).astype(int)

    def fill(self, index: np.ndarray, inputs: np.ndarray) -> None:
        """What the drives of robots ``index`` do until their first input arrives: (n, width)."""
        self._past[index] = inputs[:, None]

    def pass_on(self, control: np.ndarray) -> np.ndarray:
        """Delayed inputs (N, S, width) of inputs (N, S, width), one per simulation step."""
        line = np.concatenate([self._past, control], axis=1)
        self._past = line[:, control.shape[1] :]
        rows = self._upper - self.steps[:, None] + np.arange(control.shape[1])
        return np.take_along_axis(line, rows[:, :, None], axis=1)
