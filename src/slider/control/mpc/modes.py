"""State machine: told to go, standing robots sway, then walk; told to stop, they step until caught.

STAND → SWAY → WALK → STAND. Where a mode or a step ends is decided here, once per tick.
"""

import numpy as np

from slider.control.mpc.entry import Entry, Sway
from slider.control.mpc.memory import FEET, LEFT, RIGHT, STAND, SWAY, WALK, Gait
from slider.control.mpc.nominal import Dynamics
from slider.control.mpc.steps import Steps


class Modes:
    """Switches modes and stance feet.

    Args:
        entry: from the sway to the first step.
        steps: of those that walk.
        omega: natural frequency of the pendulum [rad/s].
        reach: forward distance from the middle within which a robot can come to a stop [m].
    """

    def __init__(self, entry: Entry, steps: Steps, omega: float, reach: float) -> None:
        self._entry, self._steps = entry, steps
        self._omega, self._reach = omega, reach

    def sway(self, gait: Gait, robots: np.ndarray, dynamics: Dynamics) -> None:
        """A sway from here, towards the foot that is still in the air."""
        middle = gait.to_heading(dynamics.foot_positions.mean(axis=1)[:, :2], robots)
        position = gait.to_heading(dynamics.com[:, :2], robots)
        height = dynamics.foot_positions[:, :, 2]
        side = np.where(height[:, LEFT] >= height[:, RIGHT], 1.0, -1.0)
        sway = self._entry.begin(middle, position, side, gait.command[robots, 0])
        gait.sway.put(robots, sway)

    def switch(
        self, gait: Gait, robots: np.ndarray, dynamics: Dynamics, contact: np.ndarray
    ) -> None:
        """Switch those that are due; ``contact`` (n, 2) of the feet."""
        self._go(gait, robots, dynamics)
        self._leave_sway(gait, robots, dynamics)
        self._leave_step(gait, robots, dynamics, contact)

    def _go(self, gait: Gait, robots: np.ndarray, dynamics: Dynamics) -> None:
        """STAND → SWAY for those that are told to go."""
        stands = gait.mode[robots] == STAND
        index = np.flatnonzero(stands & ~gait.told_to_stand(robots))
        if len(index):
            gait.mode[robots[index]] = SWAY
            self.sway(gait, robots[index], dynamics.of(index))

    def _leave_sway(self, gait: Gait, robots: np.ndarray, dynamics: Dynamics) -> None:
        """SWAY → WALK."""
        sways = np.flatnonzero(gait.mode[robots] == SWAY)
        if not len(sways):
            return
        index = sways[self._sway_ends(gait, robots[sways], dynamics.of(sways))]
        gait.mode[robots[index]] = WALK
        stance = _first_stance(gait.sway.of(robots[index]))
        self._steps.begin(gait, robots[index], dynamics.of(index), stance)

    def _sway_ends(self, gait: Gait, robots: np.ndarray, dynamics: Dynamics) -> np.ndarray:
        """Whether they can take the first step (n,); those that took too long sway again."""
        sway = gait.sway.of(robots)
        position = gait.to_heading(dynamics.com[:, :2], robots)
        velocity = gait.to_heading(dynamics.com_velocity[:, :2], robots)
        support = dynamics.foot_positions[np.arange(len(robots)), _first_stance(sway), :2]
        done = self._entry.done(sway, position, velocity, gait.to_heading(support, robots))
        self._entry.restart(sway, position, velocity)
        gait.sway.put(robots, sway)
        return done

    def _leave_step(
        self, gait: Gait, robots: np.ndarray, dynamics: Dynamics, contact: np.ndarray
    ) -> None:
        """WALK → STAND, or the next step."""
        walks = np.flatnonzero(gait.mode[robots] == WALK)
        landing = contact[walks, 1 - gait.stance[robots[walks]]]
        index = walks[self._steps.end(gait, robots[walks], landing)]
        stops = self._can_stop(gait, robots[index], dynamics.of(index))
        self._stop(gait, robots[index[stops]], dynamics.of(index[stops]))
        index = index[~stops]
        stance = 1 - gait.stance[robots[index]]
        self._steps.begin(gait, robots[index], dynamics.of(index), stance)

    def _can_stop(self, gait: Gait, robots: np.ndarray, dynamics: Dynamics) -> np.ndarray:
        """Told to stand, and the capture point is between the feet and within their length."""
        capture = dynamics.com[:, :2] + dynamics.com_velocity[:, :2] / self._omega
        feet = [gait.to_heading(dynamics.foot_positions[:, i, :2], robots) for i in FEET]
        place = gait.to_heading(capture, robots)
        apart = np.abs(feet[LEFT] - feet[RIGHT])[:, 0]
        ahead = np.abs(place - 0.5 * (feet[LEFT] + feet[RIGHT]))[:, 0]
        between = (place[:, 1] < feet[LEFT][:, 1]) & (place[:, 1] > feet[RIGHT][:, 1])
        beside = (apart < self._reach) & (ahead < self._reach / 2)
        return gait.told_to_stand(robots) & between & beside

    def _stop(self, gait: Gait, robots: np.ndarray, dynamics: Dynamics) -> None:
        if len(robots):
            gait.mode[robots] = STAND
            gait.forget_walk(robots)
            self.sway(gait, robots, dynamics)


def _first_stance(sway: Sway) -> np.ndarray:
    return np.where(sway.side > 0, LEFT, RIGHT)
