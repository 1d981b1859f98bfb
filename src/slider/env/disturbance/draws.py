"""Random numbers of disturbances, as functions of a seed and of a time.

A generator per use and time, rather than one for all: the disturbance of a robot at a time depends
neither on the rate of its controller nor on which other disturbances are on.
"""

from dataclasses import dataclass

import numpy as np

from slider.config.disturbance import DisturbanceConfig

# Uses of random numbers.
ROBOT, NOISE, PUSH, GROUND = range(4)
_STREAM = 81  # keeps these generators apart from others of the same seed


@dataclass(frozen=True)
class Disturbance:
    """What disturbs N robots.

    Attributes:
        config: which disturbances, how large.
        seeds: the robots come in blocks of the same size, one for each seed.
    """

    config: DisturbanceConfig
    seeds: tuple[int, ...]


class Draws:
    """Random numbers for ``count`` robots in blocks, each with its own seed."""

    def __init__(self, seeds: tuple[int, ...], count: int) -> None:
        if count % len(seeds):
            raise ValueError(f"expected {count} robots in {len(seeds)} blocks of the same size")
        self._seeds, self._block = seeds, count // len(seeds)

    def uniform(self, use: int, time: int, columns: int) -> np.ndarray:
        """Numbers (N, columns) in [0, 1) for a use at a time."""
        shape = (self._block, columns)
        return np.concatenate([g.uniform(size=shape) for g in self.generators(use, time)])

    def normal(self, use: int, time: int, columns: int) -> np.ndarray:
        """Standard normal numbers (N, columns) for a use at a time."""
        shape = (self._block, columns)
        return np.concatenate([g.standard_normal(shape) for g in self.generators(use, time)])

    def generators(self, use: int, time: int) -> list[np.random.Generator]:
        """One generator per seed."""
        return [np.random.default_rng([seed, _STREAM, use, time]) for seed in self._seeds]
