"""Commanded velocities of training episodes, and their growth with success."""

from typing import Any

import torch

from slider.config.train import CurriculumConfig, VelocitiesConfig


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

    def sample(self, rng: Random, count: int, share: torch.Tensor | float = 1.0) -> torch.Tensor:
        """New velocities (count, 3) within a share of the ranges; a fraction of them is zero."""
        velocities = rng.uniform(share * self._lower, share * self._upper, (count, 3))
        standing = rng.uniform(size=(count, 1)) < self._standing_fraction
        return velocities.masked_fill_(standing, 0.0)

    def changing(self, rng: Random, num_robots: int) -> torch.Tensor:
        """Numbers (n,) of the robots that get a new velocity in this control step."""
        if self._change == 0.0:
            return torch.zeros(0, dtype=torch.long, device=self._lower.device)
        return (rng.uniform(size=num_robots) < self._change).nonzero().flatten()


class Curriculum:
    """The share of the velocity ranges that is in use, on the device where episodes are counted.

    Args:
        config: where the share begins and how it grows.
        window: number of episodes after which the share may grow.
        like: a tensor on that device.

    Attributes:
        share: (1,).
    """

    def __init__(self, config: CurriculumConfig, window: int, like: torch.Tensor) -> None:
        self._config, self._window = config, window
        self.share = like.new_full((1,), config.start)
        self._ended, self._fallen = like.new_zeros(1), like.new_zeros(1)

    @property
    def enabled(self) -> bool:
        """Whether there is anything to grow."""
        return self._config.start < 1.0

    def note(self, ended: torch.Tensor, fallen: torch.Tensor) -> None:
        """Count episodes of robots (N,) that ended, some in a fall; grow after a good window."""
        if not self.enabled:
            return
        self._ended += ended.sum()
        self._fallen += fallen.sum()
        full = self._ended >= self._window
        good = full & (1.0 - self._fallen / self._ended.clip(min=1.0) >= self._config.success)
        grown = (self.share + self._config.growth).clip(max=1.0)
        self.share = grown.where(good, self.share)
        for count in (self._ended, self._fallen):
            count.masked_fill_(full, 0.0)
