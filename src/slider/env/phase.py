"""Clock that runs through the two steps of a walk at the pace of the gait library."""

import numpy as np

from slider.library.step_times import StepTimes


class Clock:
    """Phase in [0, 1) of N walks: left stance below 0.5, right stance from there on.

    Args:
        times: durations of the steps.
        period: of a control step [s].
        num_robots: N.
        halt: at zero command the clock runs on to the next change of feet and stays there, where
            the gait is in double support; without it the robot steps in place.
    """

    def __init__(
        self, times: StepTimes, period: float, num_robots: int, halt: bool = False
    ) -> None:
        self._times = times
        self._period = period
        self._halt = halt
        self.phase = np.zeros(num_robots)

    def advance(self, command: np.ndarray) -> None:
        """Move on by one control period at the step times of the commands (N, ≥ 3)."""
        step_time = self._times.at(command[:, 0], command[:, 1])
        phase = self.phase + self._period / (2.0 * step_time)
        if self._halt:
            change = np.ceil(2.0 * self.phase) / 2.0
            phase = np.where(standing(command), np.minimum(phase, change), phase)
        self.phase = phase % 1.0

    @property
    def left_stance(self) -> np.ndarray:
        """Whether the left foot should carry the robot (N,)."""
        return self.phase < 0.5


def standing(command: np.ndarray) -> np.ndarray:
    """Which commands (N, ≥ 3) of vx, vy and yaw rate mean to stand (N,)."""
    return (command[:, :3] == 0.0).all(axis=1)
