"""Commanded velocities of training episodes, and their growth with success."""

import numpy as np

from slider.config.train import CommandConfig, CurriculumConfig


class CommandSampler:
    """Draws vx, vy [m/s] and yaw rate [rad/s]."""

    def __init__(self, config: CommandConfig, control_period: float) -> None:
        self._config = config
        ranges = (config.vx, config.vy, config.yaw_rate)
        self._lower = np.array([r.lower for r in ranges])
        self._upper = np.array([r.upper for r in ranges])
        self._change = control_period / config.period if config.period > 0 else 0.0

    def sample(self, rng: np.random.Generator, count: int, share: float = 1.0) -> np.ndarray:
        """New commands (count, 3) within a share of the ranges; a fraction of them is zero."""
        commands = rng.uniform(share * self._lower, share * self._upper, (count, 3))
        commands[rng.uniform(size=count) < self._config.standing_fraction] = 0.0
        return commands

    def changing(self, rng: np.random.Generator, num_robots: int) -> np.ndarray:
        """Indices of the robots that get a new command in this control step."""
        if self._change == 0.0:
            return np.empty(0, dtype=int)
        return np.flatnonzero(rng.uniform(size=num_robots) < self._change)


class Curriculum:
    """The share of the command ranges that is in use.

    Args:
        config: where the share begins and how it grows.
        window: number of episodes after which the share may grow.
    """

    def __init__(self, config: CurriculumConfig, window: int) -> None:
        self._config, self._window = config, window
        self.share = config.start
        self._ended = self._fallen = 0

    @property
    def enabled(self) -> bool:
        """Whether there is anything to grow."""
        return self._config.start < 1.0

    def note(self, ended: int, fallen: int) -> None:
        """Count episodes that ended, ``fallen`` of them in a fall; grow after a good window."""
        self._ended += ended
        self._fallen += fallen
        if not self.enabled or self._ended < self._window:
            return
        if 1.0 - self._fallen / self._ended >= self._config.success:
            self.share = min(1.0, self.share + self._config.growth)
        self._ended = self._fallen = 0
