"""Random numbers of disturbances, as functions of a seed and of a time.

A generator per use and time, rather than one for all: the disturbance of a robot at a time depends
neither on the rate of its controller nor on which other disturbances are on.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np

from slider.config.env import DisturbanceConfig
from slider.core.arrays import Array, namespace
from slider.env.starts import NUMPY

# Uses of random numbers.
ROBOT, NOISE, PUSH, GROUND, BIAS, READING = range(6)
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
    """Random numbers for ``count`` robots in blocks, each with its own seed.

    They are arrays of NumPy, or tensors on the device of ``like``: each library has its own.
    """

    def __init__(self, seeds: tuple[int, ...], count: int, like: Array = NUMPY) -> None:
        if count % len(seeds):
            raise ValueError(f"expected {count} robots in {len(seeds)} blocks of the same size")
        self._seeds, self._block, self._like = seeds, count // len(seeds), like

    def uniform(self, use: int, time: int, columns: int) -> Array:
        """Numbers (N, columns) in [0, 1) for a use at a time."""
        return self._draw(use, time, columns, "uniform", "rand")

    def normal(self, use: int, time: int, columns: int) -> Array:
        """Standard normal numbers (N, columns) for a use at a time."""
        return self._draw(use, time, columns, "standard_normal", "randn")

    def _draw(self, use: int, time: int, columns: int, of_numpy: str, of_torch: str) -> Array:
        """By a method of NumPy's generators, or a function of torch."""
        shape, like, xp = (self._block, columns), self._like, namespace(self._like)
        if isinstance(like, np.ndarray):
            return xp.concat([getattr(g, of_numpy)(size=shape) for g in self.generators(use, time)])
        draw = partial(getattr(xp, of_torch), shape, dtype=like.dtype, device=like.device)
        generator, blocks = xp.Generator(device=like.device), []
        for key in self._keys(use, time):
            generator.manual_seed(int(np.random.SeedSequence(key).generate_state(1, np.uint64)[0]))
            blocks.append(draw(generator=generator))
        return xp.concat(blocks)

    def generators(self, use: int, time: int) -> list[np.random.Generator]:
        """One generator of NumPy per seed."""
        return [np.random.default_rng(key) for key in self._keys(use, time)]

    def _keys(self, use: int, time: int) -> list[list[int]]:
        return [[seed, _STREAM, use, time] for seed in self._seeds]
