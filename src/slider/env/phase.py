"""Clock that runs through the two steps of a walk at the pace of the gait library."""

import numpy as np

from slider.library.step_times import StepTimes


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
