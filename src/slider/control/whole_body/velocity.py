"""Reference velocity of the walking robots: on the way to the command, with integral action."""

import numpy as np

from slider.config.control import VelocityConfig
from slider.control.whole_body.memory import Memory
from slider.robot.kinematics import turn_to_heading


class ReferenceVelocity:
    """Follows the command.

    Args:
        config: acceleration and integral action.
        period: of a tick [s].
    """

    def __init__(self, config: VelocityConfig, period: float) -> None:
        self._config, self._period = config, period

    def change(self, memory: Memory, command: np.ndarray) -> None:
        """Go with ``command`` (N, 3) from now on; the reference grows from where it is."""
        changed = np.flatnonzero((command != memory.command).any(axis=1))
        memory.old[changed] = self._on_the_way(memory, changed)
        memory.changed[changed] = memory.walked[changed]
        memory.correction[changed] = 0.0
        memory.steps[changed] = np.minimum(
            memory.steps[changed], 1
        )  # no error of a stride in between
        memory.command = command

    def of(self, memory: Memory, robots: np.ndarray, ahead: float = 0.0) -> np.ndarray:
        """Velocity (n, 2) forward, left [m/s] to plan steps for, ``ahead`` [s] from now."""
        return self._on_the_way(memory, robots, ahead) + memory.correction[robots]

    def _on_the_way(self, memory: Memory, robots: np.ndarray, ahead: float = 0.0) -> np.ndarray:
        """From the old command to the new one with constant acceleration (n, 2) [m/s]."""
        old = memory.old[robots]
        change = memory.command[robots, :2] - old
        size = np.maximum(np.linalg.norm(change, axis=1), 1e-9)
        time = memory.walked[robots] - memory.changed[robots] + ahead
        share = np.minimum(1.0, self._config.acceleration * time / size)
        return old + change * share[:, None]

    def correct(self, memory: Memory, robots: np.ndarray, com: np.ndarray) -> None:
        """Add the velocity error of the last stride at the start of a step.

        Args:
            memory: memory, of which ``starts`` and ``correction`` change.
            robots: that start a step (n,).
            com: their centres of mass (n, 2) [m], world.
        """
        now = np.concatenate([com, memory.walked[robots, None]], axis=1)
        gone = now - memory.starts[robots, 0]
        memory.starts[robots] = np.stack([memory.starts[robots, 1], now], axis=1)
        # Not in the first stride, nor while it brakes in order to stand.
        known = (memory.steps[robots] > 2) & ~memory.commanded_to_stand(robots)
        known &= memory.walked[robots] - memory.changed[robots] >= self._config.integral_after
        halfway = memory.heading[robots] - 0.5 * memory.command[robots, 2] * gone[:, 2]
        mean = turn_to_heading(gone, halfway) / np.maximum(gone[:, 2:], self._period)
        error = np.where(known[:, None], memory.command[robots, :2] - mean, 0.0)
        limit = self._config.integral_limit
        total = memory.correction[robots] + self._config.integral * error
        memory.correction[robots] = np.clip(total, -limit, limit)
