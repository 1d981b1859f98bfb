"""Look gaits up by commanded velocity and phase."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import zarr
from scipy.spatial import KDTree

from slider.core.errors import UserError
from slider.library.base_motion import aligned, normalise
from slider.library.joint_table import JointTable, at_phase, standing
from slider.library.mesh import VelocityMesh, corners
from slider.library.schema import SCHEMA, VERSION
from slider.library.step_times import StepTimes
from slider.robot.names import NUM_CHANNELS, NUM_JOINTS


def open_library(path: Path) -> zarr.Group:
    """Open the Zarr store at ``path`` for reading.

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
    return group


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
        group = open_library(path)
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
    """Gaits on all nodes of the mesh of velocities, for fast look-up.

    Attributes:
        times: mean duration of a step, and the velocities of the mesh.
        reference: (nx, ny, S, 26 + 13) channels and base motion.
    """

    times: StepTimes
    reference: np.ndarray

    @classmethod
    def from_library(cls, library: GaitLibrary) -> "GaitTable":
        """Fill every node of the library's mesh of velocities."""
        mesh = VelocityMesh.of(library.velocities)
        values = np.concatenate([library.samples, aligned(library.base)], axis=2)
        reference = np.tensordot(mesh.node_weights, values, axes=1)
        step_time = mesh.node_weights @ library.step_time.mean(axis=1)
        return cls(StepTimes(mesh.vx, mesh.vy, step_time), reference)

    @property
    def joints(self) -> JointTable:
        """The joint positions alone."""
        return JointTable(self.times, np.ascontiguousarray(self.reference[..., :NUM_JOINTS]))

    def at(self, vx: np.ndarray, vy: np.ndarray, phase: np.ndarray) -> np.ndarray:
        """Channels and base motion (N, 39) of commands (N,), (N,) at phases (N,) in [0, 1).

        Bilinear in velocity, linear in time within a step: the velocities jump at touchdown.
        """
        result = at_phase(self.times, self.reference, vx, vy, phase)
        normalise(result[:, NUM_CHANNELS:])
        return result

    @cached_property
    def standing(self) -> np.ndarray:
        """Channels and base motion (39,) of a robot that stands on both feet, at rest."""
        result = standing(self.times, self.reference)
        result[NUM_JOINTS:NUM_CHANNELS] = 0.0
        result[NUM_CHANNELS + 7 :] = 0.0
        normalise(result[None, NUM_CHANNELS:])
        return result

    def channels(self, vx: np.ndarray, vy: np.ndarray) -> np.ndarray:
        """Channels (N, S, 26) of all samples of the walks at commands (N,), (N,) [m/s]."""
        samples = self.reference[..., :NUM_CHANNELS]
        around = corners(self.times.vx, self.times.vy, vx, vy)
        return sum(
            (weight[:, None, None] * samples[i, j] for i, j, weight in around),
            start=np.zeros((len(vx), *samples.shape[2:])),
        )
