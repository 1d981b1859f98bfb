"""Step time as a function of the command."""

from dataclasses import dataclass

import numpy as np

from slider.core.arrays import Array, zeros
from slider.library.mesh import Axes, corners


@dataclass(frozen=True)
class StepTimes(Axes):
    """Step time over a grid of commands.

    Attributes:
        step_time: (nx, ny, nw) [s].
    """

    step_time: Array

    @classmethod
    def constant(cls, step_time: float) -> "StepTimes":
        """The same step time [s] at every command."""
        return cls(np.zeros(1), np.zeros(1), np.zeros(1), np.full((1, 1, 1), step_time))

    def at(self, command: Array) -> Array:
        """Trilinear step times (N,) [s] of commands (N, 3); outside the grid its border's."""
        result = zeros(len(command), command)
        for node, weight in corners(self, command):
            result += weight * self.step_time[node]
        return result
