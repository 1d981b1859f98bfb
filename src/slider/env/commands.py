"""Commanded velocities of training episodes."""

import numpy as np

from slider.config.train import CommandConfig


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
