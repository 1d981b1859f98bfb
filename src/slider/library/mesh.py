"""The grid of velocities (vx, vy, yaw rate), and the weights of its gaits at any velocity.

All interpolation between gaits uses these weights. Inside the grid they are linear along each axis
between the nodes around a velocity, outside they are those of the nearest point of the border, so
that they are continuous everywhere; along an axis with one value they are constant. A node with a
gait has that gait alone. A node without one (a hole, or a velocity that only another part of the
grid has) is filled once, from the gaits before and after it along each axis, the nearer pair
counting more; if it lies between no two gaits it takes the nearest, 1 rad/s counting as 1 m/s.
Attitudes are blended as quaternions, aligned before and normalised after.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from slider.core.arrays import Array, namespace

_QUATERNION = slice(3, 7)  # of the 13 columns of the base's motion

Node = tuple[Array, Array, Array]
"""Indices (N,) along vx, vy and yaw rate."""


@dataclass(frozen=True)
class Axes:
    """Increasing velocities of a grid: vx (nx,), vy (ny,) [m/s] and yaw rate (nw,) [rad/s]."""

    vx: Array
    vy: Array
    yaw_rate: Array

    def __iter__(self) -> Iterator[np.ndarray]:
        """The three axes."""
        return iter((self.vx, self.vy, self.yaw_rate))

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each axis."""
        return tuple(len(axis) for axis in self)

    def inside(self, velocity: Array) -> Array:
        """Velocities (..., 3) clipped to the range of the grid."""
        xp = namespace(velocity)
        lower, upper = (xp.stack([axis[end] for axis in self]) for end in (0, -1))
        return velocity.clip(lower, upper)


@dataclass(frozen=True)
class VelocityMesh(Axes):
    """Every vx of a library times every vy and yaw rate, with the gaits that make up each node.

    Their weights (nx, ny, nw, G) are not negative and sum to one over the gaits.
    """

    node_weights: np.ndarray

    @classmethod
    def of(cls, velocities: np.ndarray) -> "VelocityMesh":
        """Mesh of gaits with velocities (G, 3)."""
        columns = [np.unique(column, return_inverse=True) for column in velocities.T]
        axes, places = zip(*columns, strict=True)
        gait = np.full([len(axis) for axis in axes], -1)
        gait[places] = np.arange(len(velocities))
        nodes = [_node(velocities, gait, axes, node) for node in np.ndindex(gait.shape)]
        vx, vy, yaw_rate = axes
        return cls(vx, vy, yaw_rate, np.reshape(nodes, (*gait.shape, len(velocities))))

    def weights(self, velocity: np.ndarray) -> np.ndarray:
        """Weights (N, G) of the gaits at velocities (N, 3)."""
        result = 0.0
        for node, weight in corners(self, velocity):
            result = result + weight[:, None] * self.node_weights[node]
        return np.asarray(result)


def corners(axes: Axes, velocity: Array) -> list[tuple[Node, Array]]:
    """The nodes around velocities (N, 3), up to eight: their indices and trilinear weights (N,)."""
    sides = [_sides(axis, value) for axis, value in zip(axes, velocity.T, strict=True)]
    return [((i, j, k), wx * wy * wz) for (i, wx), (j, wy), (k, wz) in product(*sides)]


def _sides(axis: Array, value: Array) -> list[tuple[Array, Array]]:
    """Indices (N,) below and above along an axis, and their weights; one for a single value.

    Values outside are clamped.
    """
    xp, last = namespace(value), len(axis) - 1
    if not last:
        return [(xp.zeros_like(value, dtype=xp.int64), xp.ones_like(value))]
    inside = value.clip(axis[0], axis[-1])
    below = (xp.searchsorted(axis, inside, side="right") - 1).clip(0, last)
    slope = xp.concat([1.0 / (axis[1:] - axis[:-1]), xp.zeros_like(axis[:1])])
    position = slope[below] * (inside - axis[below]) + below
    below = xp.asarray(position, dtype=xp.int64).clip(None, last - 1)
    share = position - below
    return [(below, 1 - share), (below + 1, share)]


def _node(
    velocities: np.ndarray, gait: np.ndarray, axes: Sequence[np.ndarray], node: tuple[int, ...]
) -> np.ndarray:
    """Weights (G,) of one node; ``gait`` (nx, ny, nw) are the gaits of nodes, or −1."""
    if gait[node] >= 0:
        return np.eye(len(velocities))[gait[node]]
    weights = np.zeros(len(velocities))
    for number, (axis, k) in enumerate(zip(axes, node, strict=True)):
        line = gait[(*node[:number], slice(None), *node[number + 1 :])]
        solved = np.flatnonzero(line >= 0)
        above = np.searchsorted(solved, k)
        if 0 < above < len(solved):  # between two gaits
            low, high = solved[above - 1], solved[above]
            fraction = (axis[k] - axis[low]) / (axis[high] - axis[low])
            weights[line[low]] += (1 - fraction) / (high - low)
            weights[line[high]] += fraction / (high - low)
    if not weights.any():
        place = [axis[k] for axis, k in zip(axes, node, strict=True)]
        weights[distances(velocities, place).argmin()] = 1.0
    return weights / weights.sum()


def distances(velocities: np.ndarray, place: Sequence[float] | np.ndarray) -> np.ndarray:
    """Distances (G,) of velocities (G, 3) from one (3,); 1 rad/s counts as 1 m/s."""
    away = velocities - np.asarray(place)
    return np.hypot(np.hypot(away[:, 0], away[:, 1]), away[:, 2])


def aligned(base: np.ndarray) -> np.ndarray:
    """Base motion (..., 13) with quaternions in one hemisphere, so that they may be blended."""
    result = base.copy()
    result[..., _QUATERNION] *= np.where(base[..., 3:4] < 0, -1.0, 1.0)
    return result


def normalise(base: np.ndarray) -> np.ndarray:
    """Normalise the quaternions of blended base motion (..., 13) in place; return it."""
    quaternion = base[..., _QUATERNION]
    quaternion /= namespace(base).linalg.vector_norm(quaternion, axis=-1, keepdims=True)
    return base
