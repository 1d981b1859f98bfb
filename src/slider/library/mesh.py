"""The grid of commanded velocities, and the weights of its gaits at any command.

All interpolation between gaits goes through these weights. A command inside the grid is bilinear
in the four nodes around it and a command outside takes the border's, so that weights are
continuous everywhere. A node with a gait is that gait alone. A node without one (a hole, or a
velocity that only another part of the grid has) is filled once, from the gaits before and after
it in its row and in its column, the nearer pair counting more; where it lies between no two
gaits it is the nearest gait. Attitudes are blended as quaternions, aligned before and made unit
after.
"""

from dataclasses import dataclass

import numpy as np

_QUATERNION = slice(3, 7)  # of the 13 columns of the base's motion


@dataclass(frozen=True)
class VelocityMesh:
    """Every vx of a library times every vy, with the gaits that make up each node.

    Attributes:
        vx, vy: increasing velocities [m/s], (nx,), (ny,).
        node_weights: (nx, ny, G), not negative; they sum to one over the gaits.
    """

    vx: np.ndarray
    vy: np.ndarray
    node_weights: np.ndarray

    @classmethod
    def of(cls, velocities: np.ndarray) -> "VelocityMesh":
        """Mesh of gaits with velocities (G, 2) [m/s]."""
        vx, column = np.unique(velocities[:, 0], return_inverse=True)
        vy, row = np.unique(velocities[:, 1], return_inverse=True)
        gait = np.full((len(vx), len(vy)), -1)
        gait[column, row] = np.arange(len(velocities))
        weights = np.zeros((*gait.shape, len(velocities)))
        for i, j in np.ndindex(gait.shape):
            weights[i, j] = _node(velocities, gait, vx, vy, i, j)
        return cls(vx, vy, weights)

    def weights(self, vx: np.ndarray, vy: np.ndarray) -> np.ndarray:
        """Weights (N, G) of the gaits at commands (N,), (N,) [m/s]."""
        result = 0.0
        for i, j, weight in corners(self.vx, self.vy, vx, vy):
            result = result + weight[:, None] * self.node_weights[i, j]
        return np.asarray(result)


def cell(axis: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Index (N,) of the grid value below and the fraction (N,) above it; clamped outside."""
    if len(axis) == 1:
        return np.zeros(len(value), dtype=int), np.zeros(len(value))
    position = np.interp(value, axis, np.arange(len(axis)))
    index = np.minimum(position.astype(int), len(axis) - 2)
    return index, position - index


def corners(
    vx_axis: np.ndarray, vy_axis: np.ndarray, vx: np.ndarray, vy: np.ndarray
) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """The four nodes around commands (N,): their indices (N,), (N,) and bilinear weights (N,)."""
    i, a = cell(vx_axis, vx)
    j, b = cell(vy_axis, vy)
    right, up = np.minimum(i + 1, len(vx_axis) - 1), np.minimum(j + 1, len(vy_axis) - 1)
    sides = [(i, 1 - a), (right, a)]
    levels = [(j, 1 - b), (up, b)]
    return [(x, y, wx * wy) for x, wx in sides for y, wy in levels]


def _node(
    velocities: np.ndarray, gait: np.ndarray, vx: np.ndarray, vy: np.ndarray, i: int, j: int
) -> np.ndarray:
    """Weights (G,) of one node."""
    weights = np.zeros(len(velocities))
    if gait[i, j] >= 0:
        weights[gait[i, j]] = 1.0
        return weights
    pairs = [_bracket(gait[:, j], vx, i), _bracket(gait[i], vy, j)]
    for first, second, fraction, span in filter(None, pairs):
        weights[first] += (1 - fraction) / span
        weights[second] += fraction / span
    if not weights.any():
        distance = np.hypot(velocities[:, 0] - vx[i], velocities[:, 1] - vy[j])
        weights[distance.argmin()] = 1.0
    return weights / weights.sum()


def _bracket(line: np.ndarray, axis: np.ndarray, k: int) -> tuple[int, int, float, int] | None:
    """Gaits before and after place k of a row or column, the fraction between them, their span."""
    there = np.flatnonzero(line >= 0)
    before, after = there[there < k], there[there > k]
    if not len(before) or not len(after):
        return None
    low, high = before[-1], after[0]
    fraction = (axis[k] - axis[low]) / (axis[high] - axis[low])
    return int(line[low]), int(line[high]), float(fraction), int(high - low)


def aligned(base: np.ndarray) -> np.ndarray:
    """Base motion (..., 13) with quaternions on one half sphere, so that they may be blended."""
    result = base.copy()
    result[..., _QUATERNION] *= np.where(base[..., 3:4] < 0, -1.0, 1.0)
    return result


def normalise(base: np.ndarray) -> np.ndarray:
    """Make the quaternions of blended motion (..., 13) unit again, in place; return it."""
    quaternion = base[..., _QUATERNION]
    quaternion /= np.linalg.norm(quaternion, axis=-1, keepdims=True)
    return base
