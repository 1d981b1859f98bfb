"""State machine: standing robots sway, then walk; at zero command they step until they can stop.

STAND → SWAY → WALK → STAND. Where a mode or a step ends is decided here, once per tick.
"""

from typing import TYPE_CHECKING

import numpy as np

from slider.control.whole_body.entry import Entry, Sway
from slider.control.whole_body.memory import FEET, LEFT, RIGHT, STAND, SWAY, WALK, Memory
from slider.control.whole_body.nominal import Dynamics

if TYPE_CHECKING:
    from slider.control.whole_body.controller import Stepping


class Modes:
    """Switches modes and stance feet.

    Args:
        entry: from the sway to the first step.
        steps: how those step that walk.
        omega: natural frequency of the pendulum [rad/s].
        reach: forward distance from the middle within which a robot can come to a stop [m].
    """

    def __init__(self, entry: Entry, steps: "Stepping", omega: float, reach: float) -> None:
        self._entry, self._steps = entry, steps
        self._omega, self._reach = omega, reach

    def sway(self, memory: Memory, robots: np.ndarray, dynamics: Dynamics) -> None:
        """A sway from here, towards the foot that is still in the air."""
        middle = memory.to_heading(dynamics.foot_positions.mean(axis=1)[:, :2], robots)
        position = memory.to_heading(dynamics.com[:, :2], robots)
        height = dynamics.foot_positions[:, :, 2]
        side = np.where(height[:, LEFT] >= height[:, RIGHT], 1.0, -1.0)
        sway = self._entry.begin(middle, position, side, memory.command[robots, 0])
        memory.sway.put(robots, sway)

    def switch(
        self, memory: Memory, robots: np.ndarray, dynamics: Dynamics, contact: np.ndarray
    ) -> None:
        """Switch those that are due; ``contact`` (n, 2) of the feet."""
        self._go(memory, robots, dynamics)
        self._leave_sway(memory, robots, dynamics)
        self._leave_step(memory, robots, dynamics, contact)

    def _go(self, memory: Memory, robots: np.ndarray, dynamics: Dynamics) -> None:
        """STAND → SWAY where the command is not zero."""
        stands = memory.mode[robots] == STAND
        index = np.flatnonzero(stands & ~memory.commanded_to_stand(robots))
        if len(index):
            memory.mode[robots[index]] = SWAY
            self.sway(memory, robots[index], dynamics.of(index))

    def _leave_sway(self, memory: Memory, robots: np.ndarray, dynamics: Dynamics) -> None:
        """SWAY → WALK."""
        sways = np.flatnonzero(memory.mode[robots] == SWAY)
        if not len(sways):
            return
        index = sways[self._sway_ends(memory, robots[sways], dynamics.of(sways))]
        memory.mode[robots[index]] = WALK
        stance = _first_stance(memory.sway.of(robots[index]))
        self._steps.begin(memory, robots[index], dynamics.of(index), stance)

    def _sway_ends(self, memory: Memory, robots: np.ndarray, dynamics: Dynamics) -> np.ndarray:
        """Whether they can take the first step (n,); those that took too long sway again."""
        sway = memory.sway.of(robots)
        position = memory.to_heading(dynamics.com[:, :2], robots)
        velocity = memory.to_heading(dynamics.com_velocity[:, :2], robots)
        support = dynamics.foot_positions[np.arange(len(robots)), _first_stance(sway), :2]
        done = self._entry.done(sway, position, velocity, memory.to_heading(support, robots))
        self._entry.restart(sway, position, velocity)
        memory.sway.put(robots, sway)
        return done

    def _leave_step(
        self, memory: Memory, robots: np.ndarray, dynamics: Dynamics, contact: np.ndarray
    ) -> None:
        """WALK → STAND, or the next step."""
        walks = np.flatnonzero(memory.mode[robots] == WALK)
        landing = contact[walks, 1 - memory.stance[robots[walks]]]
        index = walks[self._steps.end(memory, robots[walks], landing)]
        stops = memory.commanded_to_stand(robots[index])
        if stops.any():
            standing = index[stops]
            stops[stops] = self._can_stop(memory, robots[standing], dynamics.of(standing))
            self._stop(memory, robots[index[stops]], dynamics.of(index[stops]))
            index = index[~stops]
        if not len(index):
            return
        stance = 1 - memory.stance[robots[index]]
        self._steps.begin(memory, robots[index], dynamics.of(index), stance)

    def _can_stop(self, memory: Memory, robots: np.ndarray, dynamics: Dynamics) -> np.ndarray:
        """Where the capture point is between the feet and within their length."""
        capture = dynamics.com[:, :2] + dynamics.com_velocity[:, :2] / self._omega
        feet = [memory.to_heading(dynamics.foot_positions[:, i, :2], robots) for i in FEET]
        place = memory.to_heading(capture, robots)
        apart = np.abs(feet[LEFT] - feet[RIGHT])[:, 0]
        ahead = np.abs(place - 0.5 * (feet[LEFT] + feet[RIGHT]))[:, 0]
        between = (place[:, 1] < feet[LEFT][:, 1]) & (place[:, 1] > feet[RIGHT][:, 1])
        beside = (apart < self._reach) & (ahead < self._reach / 2)
        return between & beside

    def _stop(self, memory: Memory, robots: np.ndarray, dynamics: Dynamics) -> None:
        if len(robots):
            memory.mode[robots] = STAND
            memory.forget_walk(robots)
            self.sway(memory, robots, dynamics)


def _first_stance(sway: Sway) -> np.ndarray:
    return np.where(sway.side > 0, LEFT, RIGHT)
