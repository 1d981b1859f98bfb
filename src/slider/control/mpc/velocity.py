"""Reference velocity: it grows from the old command to the new one, without error in the mean."""

import numpy as np

from slider.config.control import PlannerConfig
from slider.control.mpc.memory import Gait
from slider.robot.kinematics import turn_to_heading


class ReferenceVelocity:
    """Follows the command.

    Args:
        config: acceleration and integral action.
        period: of a tick [s].
    """

    def __init__(self, config: PlannerConfig, period: float) -> None:
        self._config, self._period = config, period

    def change(self, gait: Gait, command: np.ndarray) -> None:
        """Go with ``command`` (N, 3) from now on; the reference grows from where it is."""
        changed = np.flatnonzero((command != gait.command).any(axis=1))
        gait.old[changed] = self._on_the_way(gait, changed)
        gait.changed[changed] = gait.walked[changed]
        gait.correction[changed] = 0.0
        gait.steps[changed] = np.minimum(gait.steps[changed], 1)  # no error of a stride in between
        gait.command = command

    def of(self, gait: Gait, robots: np.ndarray) -> np.ndarray:
        """Velocity (n, 2) forward, left [m/s] that the steps are planned for."""
        return self._on_the_way(gait, robots) + gait.correction[robots]

    def _on_the_way(self, gait: Gait, robots: np.ndarray) -> np.ndarray:
        """From the old command to the new one with constant acceleration (n, 2) [m/s]."""
        old = gait.old[robots]
        change = gait.command[robots, :2] - old
        size = np.maximum(np.linalg.norm(change, axis=1), 1e-9)
        time = gait.walked[robots] - gait.changed[robots]
        share = np.minimum(1.0, self._config.acceleration * time / size)
        return old + change * share[:, None]

    def correct(self, gait: Gait, robots: np.ndarray, com: np.ndarray) -> None:
        """Add the velocity error of the last stride at the start of a step.

        Args:
            gait: memory, of which ``starts`` and ``correction`` change.
            robots: that start a step (n,).
            com: their centres of mass (n, 2) [m], world.
        """
        now = np.concatenate([com, gait.walked[robots, None]], axis=1)
        gone = now - gait.starts[robots, 0]
        gait.starts[robots] = np.stack([gait.starts[robots, 1], now], axis=1)
        # Not in the first stride, nor while it brakes in order to stand.
        known = (gait.steps[robots] > 2) & ~gait.told_to_stand(robots)
        halfway = gait.heading[robots] - 0.5 * gait.command[robots, 2] * gone[:, 2]
        mean = turn_to_heading(gone, halfway) / np.maximum(gone[:, 2:], self._period)
        error = np.where(known[:, None], gait.command[robots, :2] - mean, 0.0)
        limit = self._config.integral_limit
        total = gait.correction[robots] + self._config.integral * error
        gait.correction[robots] = np.clip(total, -limit, limit)
