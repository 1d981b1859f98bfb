"""Clock that runs through the two steps of a walk at the pace of the gait library."""

from typing import TYPE_CHECKING

import numpy as np

from slider.config.env import HaltConfig
from slider.core.arrays import Array

if TYPE_CHECKING:
    from slider.env.underlying import UnderlyingController
    from slider.library.step_times import StepTimes


class Clock:
    """Phase in [0, 1) of N walks: left stance below 0.5, right stance from there on.

    At zero command a robot steps in place, or, with halting, stands: once its low-passed velocity
    is less than ``halt.below``, its clock stays at the next change of feet, where the gait is in
    double support, until there is a command, or the velocity reaches ``halt.above``: the robot
    tips over and has to step.

    Args:
        times: durations of the steps.
        period: of a control step [s].
        num_robots: N.
        halt: of the clock at zero command.

    Attributes:
        phase: (N,).
        halted: clocks that stay (N,).
    """

    def __init__(
        self, times: "StepTimes", period: float, num_robots: int, halt: HaltConfig
    ) -> None:
        self._times = times
        self._period = period
        self._halt = halt
        self.phase = np.zeros(num_robots)
        self.halted = np.zeros(num_robots, dtype=bool)

    def reset(
        self,
        index: np.ndarray,
        phase: np.ndarray | float,
        command: np.ndarray,
        speed: np.ndarray,
    ) -> None:
        """Set the phases (n,) of robots ``index``, with commands (n, ≥ 3) and speeds (n,) [m/s].

        Those commanded to stand are halted at once where the phase is a change of feet.
        """
        self.phase[index] = phase
        change = (2.0 * self.phase[index]) % 1.0 == 0.0
        self.halted[index] = change & standing(command) & (speed < self._halt.below)

    def advance(
        self,
        command: np.ndarray,
        reference: np.ndarray,
        mean_speed: np.ndarray,
        speed: np.ndarray,
    ) -> None:
        """Move on by one control period at the step times of the gaits in use.

        Args:
            command: (N, ≥ 3) vx, vy [m/s], yaw rate [rad/s].
            reference: velocities (N, 2) [m/s]; the yaw rate is the commanded one.
            mean_speed, speed: of the base, low-passed and now (N,) [m/s].
        """
        step_time = self._times.at(np.column_stack([reference, command[:, 2]]))
        phase = self.phase + self._period / (2.0 * step_time)
        if self.halts:
            change = np.ceil(2.0 * self.phase) / 2.0
            slow = (speed < self._halt.above) & (self.halted | (mean_speed < self._halt.below))
            self.halted = standing(command) & slow & (phase >= change)
            phase = np.where(self.halted, change, phase)
        self.phase = phase % 1.0

    @property
    def halts(self) -> bool:
        """Whether robots stand at zero command, instead of stepping in place."""
        return self._halt.below > 0

    @property
    def left_stance(self) -> np.ndarray:
        """Whether the left foot should carry the robot (N,)."""
        return self.phase < 0.5


class StepClock:
    """The phase of the steps that a controller makes; halted while it makes none."""

    halts = False

    def __init__(self, controller: "UnderlyingController") -> None:
        self._controller = controller

    @property
    def phase(self) -> np.ndarray:
        """Phase (N,) in [0, 1), as that of :class:`Clock`, at the controller's last tick."""
        return self._controller.phase

    @property
    def halted(self) -> np.ndarray:
        """Whether it stands or sways on both feet (N,)."""
        return self._controller.halted

    @property
    def left_stance(self) -> np.ndarray:
        """Whether the left foot carries the robot, or is about to (N,)."""
        return self.phase < 0.5

    def reset(self, *_: object) -> None:
        """The controller is reset."""

    def advance(self, *_: object) -> None:
        """The controller moves on, tick by tick."""


def standing(command: Array) -> Array:
    """Which commands (N, ≥ 3) of vx, vy and yaw rate mean to stand (N,)."""
    return (command[:, :3] == 0.0).all(axis=1)
