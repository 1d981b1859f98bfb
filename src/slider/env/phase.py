"""Clock that runs through the two steps of a walk at the pace of the gait library."""

from typing import TYPE_CHECKING

from slider.config.env import HaltConfig
from slider.core.arrays import Array, namespace, tensors

if TYPE_CHECKING:
    from slider.library.lookup import StepTimes


class Clock:
    """Phase in [0, 1) of N walks: left stance below 0.5, right stance from there on.

    At zero command a robot steps in place or, with halting, stands: once its filtered speed is
    below ``halt.below``, its clock halts at the next change of stance foot, where the gait is in
    double support, until there is a command or the speed reaches ``halt.above``, at which the robot
    tips over and must step. ``period`` is the control period [s].

    Attributes:
        phase: (N,).
        halted: whether the clocks are halted (N,).
    """

    def __init__(
        self,
        times: "StepTimes",
        period: float,
        num_robots: int,
        halt: HaltConfig,
        like: Array,
    ) -> None:
        self._times = tensors(times, like)
        self._period = period
        self._halt = halt
        self.phase = like.new_zeros(num_robots)
        self.halted = self.phase > 0

    def reset(self, index: Array, phase: Array | float, command: Array, speed: Array) -> None:
        """Set the phases (n,) of robots ``index``, with commands (n, ≥ 3) and speeds (n,) [m/s].

        Robots commanded to stand are halted at once if they are slower than ``halt.below`` and the
        phase is at a change of stance foot.
        """
        self.phase[index] = phase
        change = (2.0 * self.phase[index]) % 1.0 == 0.0
        self.halted[index] = change & standing(command) & (speed < self._halt.below)

    def advance(self, command: Array, reference: Array, mean_speed: Array, speed: Array) -> None:
        """Advance by one control period at the step times of the gaits in use.

        Args:
            command: (N, ≥ 3) vx, vy [m/s], yaw rate [rad/s].
            reference: velocities (N, 2) [m/s]; the yaw rate is the commanded one.
            mean_speed, speed: filtered and current speed of the base (N,) [m/s].
        """
        step_time = self._times.at(gait_velocity_of(reference, command))
        phase = self.phase + self._period / (2.0 * step_time)
        if self.halts:
            change = (2.0 * self.phase).ceil() / 2.0
            slow = (speed < self._halt.above) & (self.halted | (mean_speed < self._halt.below))
            self.halted = standing(command) & slow & (phase >= change)
            phase = change.where(self.halted, phase)
        self.phase = phase % 1.0

    @property
    def halts(self) -> bool:
        """Whether robots stand at zero command, instead of stepping in place."""
        return self._halt.below > 0


def gait_velocity_of(reference: Array, command: Array) -> Array:
    """Command (N, 3) of the gait in use: reference velocity (N, 2), commanded yaw rate."""
    parts = [reference, command[:, 2:3]]
    return namespace(parts[0]).concat(parts, axis=1)


def standing(command: Array) -> Array:
    """Whether commands (N, ≥ 3) of vx, vy and yaw rate are zero, which means standing (N,)."""
    return (command[:, :3] == 0.0).all(axis=1)
