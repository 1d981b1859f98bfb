"""Commanded velocities of training episodes."""

from typing import Any

import torch

from slider.config.train import VelocitiesConfig


class Random:
    """Random numbers of a seed in the precision and on the device of ``like``."""

    def __init__(self, seed: int, like: torch.Tensor) -> None:
        self._generator = torch.Generator(like.device).manual_seed(seed)
        self._options: dict[str, Any] = {"dtype": like.dtype, "device": like.device}

    def uniform(self, low: Any = 0.0, high: Any = 1.0, size: Any = ()) -> torch.Tensor:
        """Uniform numbers in [low, high) of a shape."""
        share = torch.rand(size, generator=self._generator, **self._options)
        return low + (high - low) * share

    def standard_normal(self, size: Any = ()) -> torch.Tensor:
        """Standard normal numbers of a shape."""
        return torch.randn(size, generator=self._generator, **self._options)


class VelocitySampler:
    """Draws velocities: vx, vy [m/s] and yaw rate [rad/s], on the device of ``like``."""

    def __init__(self, config: VelocitiesConfig, control_period: float, like: torch.Tensor) -> None:
        self._standing_fraction = config.standing_fraction
        ranges = (config.vx, config.vy, config.yaw_rate)
        self._lower = like.new_tensor([r.lower for r in ranges])
        self._upper = like.new_tensor([r.upper for r in ranges])
        self._change = control_period / config.period if config.period > 0 else 0.0

    def sample(self, rng: Random, count: int) -> torch.Tensor:
        """New velocities (count, 3) within the ranges; a fraction of them is zero."""
        velocities = rng.uniform(self._lower, self._upper, (count, 3))
        standing = rng.uniform(size=(count, 1)) < self._standing_fraction
        return velocities.masked_fill_(standing, 0.0)

    def changing(self, rng: Random, num_robots: int) -> torch.Tensor:
        """Numbers (n,) of the robots that get a new velocity in this control step."""
        if self._change == 0.0:
            return torch.zeros(0, dtype=torch.long, device=self._lower.device)
        return (rng.uniform(size=num_robots) < self._change).nonzero().flatten()
