"""The ground: flat, or a grid of random heights that repeats itself."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from slider.config.env import GroundConfig
from slider.core.arrays import Array, namespace, zeros


class Ground(Protocol):
    """Height of the ground under each of N robots."""

    @property
    def flat(self) -> bool:
        """Whether it is z = 0 everywhere."""
        ...

    def height(self, points: Array) -> Array:
        """Heights (N, ...) [m] at points (N, ..., 2) of the world [m]."""
        ...


@dataclass(frozen=True)
class FlatGround:
    """A plane at z = 0."""

    flat: bool = True

    def height(self, points: Array) -> Array:
        """Zeros (N, ...) for points (N, ..., 2)."""
        return zeros(points.shape[:-1], points)


FLAT = FlatGround()


@dataclass(frozen=True)
class UnevenGround:
    """One grid for N robots, each of which starts somewhere else on it.

    Attributes:
        tile: heights [m] of the grid points of one period (n, n), rows along y.
        cell: edge of a cell [m].
        offset: (N, 2) the world's origin of a robot lies at minus this on the grid [m].
    """

    tile: Array
    cell: float
    offset: Array
    flat: bool = False

    def height(self, points: Array) -> Array:
        """Heights (N, ...) [m] at points (N, ..., 2) [m], on the triangles that MuJoCo makes."""
        shape = (len(points),) + (1,) * (points.ndim - 2) + (2,)
        scaled = (points - self.offset.reshape(shape)) / self.cell
        xp = namespace(scaled)
        below = xp.floor(scaled)
        place, share = xp.asarray(below, dtype=xp.int64), scaled - below
        column, row, x, y = place[..., 0], place[..., 1], share[..., 0], share[..., 1]
        a, b = self._at(row, column), self._at(row, column + 1)
        c, d = self._at(row + 1, column), self._at(row + 1, column + 1)
        # The edge between the triangles of a cell goes from a to d.
        return xp.where(x >= y, a + x * (b - a) + y * (d - b), a + y * (c - a) + x * (d - c))

    def _at(self, row: Array, column: Array) -> Array:
        return self.tile[row % len(self.tile), column % len(self.tile)]


def random_tile(config: GroundConfig, rng: np.random.Generator) -> Array:
    """Heights [m] of one period (n, n), uniform within ± the amplitude."""
    points = round(config.period / config.cell)
    return config.amplitude * rng.uniform(-1.0, 1.0, (points, points))
