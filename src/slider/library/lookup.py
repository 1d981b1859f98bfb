"""Look gaits up by commanded velocity and phase."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import zarr
from scipy.interpolate import LinearNDInterpolator
from scipy.spatial import KDTree

from slider.core.errors import UserError
from slider.library.schema import SCHEMA, VERSION
from slider.library.step_times import StepTimes, cell
from slider.robot.names import CHANNELS

_NUM_CHANNELS = len(CHANNELS)


@dataclass(frozen=True)
class GaitLibrary:
    """All gaits of a library.

    Attributes:
        velocities: (G, 2) commanded vx, vy [m/s].
        samples: (G, S, 26) channels of ``slider.robot.names.CHANNELS`` at S samples per walk,
            the first half in left stance.
        base: (G, S, 13) base position [m] relative to the stance foot at the start of the walk,
            quaternion w, x, y, z, linear velocity [m/s] (world), angular velocity [rad/s] (base).
        step_time: (G, 2) duration of the two steps [s].
    """

    velocities: np.ndarray
    samples: np.ndarray
    base: np.ndarray
    step_time: np.ndarray

    @classmethod
    def load(cls, path: Path) -> "GaitLibrary":
        """Read the Zarr store at ``path``.

        Raises:
            UserError: not a gait library, or of another version.
        """
        try:
            group = zarr.open_group(path, mode="r")
        except (FileNotFoundError, ValueError):
            raise UserError(f"expected a gait library at {path}, found none") from None
        found = (group.attrs.get("schema"), group.attrs.get("version"))
        if found != (SCHEMA, VERSION):
            raise UserError(f"{path}: expected {SCHEMA} version {VERSION}, found {found}")
        names = ("velocities", "samples", "base", "step_time")
        return cls(**{name: np.asarray(group[name][...]) for name in names})  # type: ignore

    def nearest(self, vx: np.ndarray, vy: np.ndarray) -> np.ndarray:
        """Index (N,) of the gait nearest to each command (N,), (N,) [m/s]."""
        return np.asarray(self._tree.query(np.stack([vx, vy], axis=1))[1])

    @cached_property
    def _tree(self) -> KDTree:
        return KDTree(self.velocities)


@dataclass(frozen=True)
class GaitTable:
    """Gaits interpolated onto a regular grid of velocities, for fast look-up.

    Attributes:
        times: mean duration of a step, and the velocities of the grid.
        reference: (nx, ny, S, 26 + 13) channels and base motion.
    """

    times: StepTimes
    reference: np.ndarray

    @classmethod
    def from_library(
        cls, library: GaitLibrary, vx_step: float = 0.05, vy_step: float = 0.05
    ) -> "GaitTable":
        """Interpolate linearly between gaits; velocities outside their hull take the nearest."""
        vx_axis = _axis(library.velocities[:, 0], vx_step)
        vy_axis = _axis(library.velocities[:, 1], vy_step)
        grid = np.stack(np.meshgrid(vx_axis, vy_axis, indexing="ij"), axis=-1)
        shape = grid.shape[:2]
        base = _aligned(library.base)
        values = np.concatenate([library.samples, base], axis=2)
        flat = np.concatenate(
            [library.step_time.mean(axis=1)[:, None], values.reshape(len(values), -1)], axis=1
        )
        table = _interpolate(library.velocities, flat, grid.reshape(-1, 2))
        reference = table[:, 1:].reshape(*shape, *values.shape[1:])
        return cls(StepTimes(vx_axis, vy_axis, table[:, 0].reshape(shape)), reference)

    def at(self, vx: np.ndarray, vy: np.ndarray, phase: np.ndarray) -> np.ndarray:
        """Channels and base motion (N, 39) of commands (N,), (N,) at phases (N,) in [0, 1).

        Bilinear in velocity, linear in time within a step: the velocities jump at touchdown.
        """
        i, a = cell(self.times.vx, vx)
        j, b = cell(self.times.vy, vy)
        k, c = self._sample(phase)
        nodes = self.reference.shape
        flat = self.reference.reshape(-1, nodes[-1])
        right = np.minimum(i + 1, nodes[0] - 1)
        up = np.minimum(j + 1, nodes[1] - 1)
        result = np.zeros((len(vx), nodes[-1]))
        for x, wx in ((i, 1 - a), (right, a)):
            for y, wy in ((j, 1 - b), (up, b)):
                row = (x * nodes[1] + y) * nodes[2] + k
                result += (wx * wy * (1 - c))[:, None] * flat[row]
                result += (wx * wy * c)[:, None] * flat[row + 1]
        quaternion = result[:, _QUATERNION]
        quaternion /= np.linalg.norm(quaternion, axis=1, keepdims=True)
        return result

    def _sample(self, phase: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Index of the sample before a phase, and the fraction of the way to the next."""
        per_step = self.reference.shape[2] // 2
        step = (phase >= 0.5).astype(int)
        position = (2.0 * phase - step) * (per_step - 1)
        node = np.clip(position.astype(int), 0, per_step - 2)
        return step * per_step + node, position - node


_QUATERNION = slice(_NUM_CHANNELS + 3, _NUM_CHANNELS + 7)


def _axis(values: np.ndarray, step: float) -> np.ndarray:
    """Regular values from the least to the greatest, about ``step`` apart."""
    lower, upper = float(values.min()), float(values.max())
    count = max(1, round((upper - lower) / step) + 1) if upper > lower else 1
    return np.linspace(lower, upper, max(count, 2 if upper > lower else 1))


def _aligned(base: np.ndarray) -> np.ndarray:
    """Base motion with quaternions on one half sphere, so that they may be blended."""
    aligned = base.copy()
    sign = np.where(base[..., 3:4] < 0, -1.0, 1.0)
    aligned[..., 3:7] *= sign
    return aligned


def _interpolate(points: np.ndarray, values: np.ndarray, queries: np.ndarray) -> np.ndarray:
    """Piecewise linear values (Q, K) at queries (Q, 2); nearest outside the points' hull."""
    spread = np.ptp(points, axis=0) > 0
    if spread.sum() < 2:
        return _interpolate_line(points[:, spread], values, queries[:, spread])
    result = LinearNDInterpolator(points, values)(queries)
    outside = np.isnan(result[:, 0])
    nearest = KDTree(points).query(queries[outside])[1]
    result[outside] = values[nearest]
    return result


def _interpolate_line(points: np.ndarray, values: np.ndarray, queries: np.ndarray) -> np.ndarray:
    if points.shape[1] == 0:
        return np.repeat(values[:1], len(queries), axis=0)
    order = np.argsort(points[:, 0])
    index, fraction = cell(points[order, 0], queries[:, 0])
    ordered = values[order]
    after = np.minimum(index + 1, len(ordered) - 1)
    return ordered[index] * (1 - fraction[:, None]) + ordered[after] * fraction[:, None]
