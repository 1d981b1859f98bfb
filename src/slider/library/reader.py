"""Layout and reading of the gait library, see ``docs/reference/gait-library.md``."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import zarr

from slider.config.convert import from_dict
from slider.config.robot import Geometry, Mechanism
from slider.core.errors import UserError
from slider.library.mesh import VelocityMesh, distances
from slider.robot import names
from slider.robot.names import SIDES, VELOCITY, velocity_text

STORE = "library.zarr"
SCHEMA = "slider-gait-library"
VERSION = 5


class Array(NamedTuple):
    """Unit of an array of the store, and its axes after the first one, which is the gait."""

    unit: str
    axes: tuple[str, ...] = ()


ARRAYS: dict[str, Array] = {
    "velocities": Array("m/s, m/s, rad/s", ("component",)),
    "samples": Array("see channel_units", ("sample", "channel")),
    "time": Array("s", ("sample",)),
    "step_time": Array("s", ("step",)),
    "base": Array("m, quaternion w x y z, m/s (world), rad/s (base)", ("sample", "base_channel")),
    "contact": Array("1: stance", ("sample", "foot")),
    "coefficients": Array("rad", ("step", "knee_joint", "coefficient")),
    "roll": Array("rad, rad/s, rad/s^2", ("step", "node", "roll_channel")),
    "decoupling": Array("rad/s^2 | m/s^2, 1", ("sample", "decoupling_channel")),
    "knee_positions": Array("rad", ("sample", "knee_joint")),
    "knee_velocities": Array("rad/s", ("sample", "knee_joint")),
    "knee_torques": Array("N m", ("sample", "knee_joint")),
    "efforts": Array("N m, N (slide)", ("sample", "joint")),
    "ground_wrench": Array("N, N m at the foot line, world axes", ("sample", "wrench_component")),
    "swing_foot": Array("m relative to the stance foot", ("sample", "coordinate")),
    "cost": Array("see cost_unit"),
    "max_violation": Array("SI unit of the worst constraint"),
    "iterations": Array("1"),
    "residuals": Array("unit of the constraint", ("constraint",)),
}
# One value per gait; xarray reads them as coordinates.
COORDINATES: dict[str, Array] = {
    "vx": Array("m/s"),
    "vy": Array("m/s"),
    "yaw_rate": Array("rad/s"),
    "status": Array("IPOPT's return status"),
}

CONSTRAINT = "constraint"
"""Axis of the residuals; its names, those of the formulation, are read from the gaits."""
BASE_CHANNELS = (
    *("x", "y", "z"),
    *("qw", "qx", "qy", "qz"),
    *("vx", "vy", "vz"),
    *("wx", "wy", "wz"),
)
WRENCH_COMPONENTS = ("fx", "fy", "fz", "mx", "my", "mz")


def labels(geometry: Geometry) -> dict[str, tuple[str, ...]]:
    """Names along the axes: one-dimensional arrays of text, which xarray reads as coordinates."""
    return {
        "component": VELOCITY,
        "channel": names.channels(geometry),
        "joint": names.joint_names(geometry),
        "knee_joint": names.knee_joint_names(geometry),
        "step": SIDES,  # by its stance foot
        "foot": SIDES,
        "base_channel": BASE_CHANNELS,
        "wrench_component": WRENCH_COMPONENTS,
        "coordinate": ("x", "y", "z"),
        "decoupling_channel": ("least_singular_value", "condition_number"),
        "roll_channel": ("roll", "roll_rate", "roll_acceleration"),
    }


# Attributes from the configuration: robot and settings of the gaits (``gait.*``), ...
ORIGIN = ("robot", "dynamics", "cost", "kinematic_map")
# ... and from the optimisation: the velocities without a gait, the unit of the cost.
OUTCOME = ("holes", "cost_unit")


_NAMES = (*ARRAYS, *COORDINATES, CONSTRAINT)
MAKE_LIBRARY = "snakemake -j2 gait_library"
_REMAKE = f"make it again with `{MAKE_LIBRARY}`"
_SAME = 1e-6  # velocities closer than this are equal [m/s, rad/s]


@dataclass(frozen=True)
class Hole:
    """A velocity without a gait; ``violated`` are constraints with value and bound, worst first."""

    vx: float
    vy: float
    yaw_rate: float
    status: str
    iterations: int
    max_violation: float
    violated: Sequence[str]

    @property
    def velocity(self) -> tuple[float, float, float]:
        """vx, vy [m/s], yaw rate [rad/s]."""
        return self.vx, self.vy, self.yaw_rate

    @property
    def reason(self) -> str:
        """IPOPT's return status, and the three worst violated constraints by name."""
        return "; ".join([self.status, *self.violated[:3]])


@dataclass(frozen=True)
class GaitLibrary:
    """A gait library of G gaits with S samples per walk.

    Attributes:
        arrays: name → values, gaits along the first axis, each read on first use; names, axes and
            units are those of ``ARRAYS``.
        attributes: of the store, as read from JSON; the properties below convert them.
    """

    arrays: Mapping[str, np.ndarray]
    attributes: Mapping[str, Any]

    @classmethod
    def load(cls, path: Path) -> "GaitLibrary":
        """Open the Zarr store at ``path``.

        Raises:
            UserError: it is not a gait library, has another version, or lacks a part.
        """
        try:
            group = zarr.open_group(path, mode="r")
        except (FileNotFoundError, ValueError):
            raise UserError(f"expected a gait library at {path}, found none") from None
        attributes = group.attrs.asdict()
        schema, version = attributes.get("schema"), attributes.get("version")
        if schema != SCHEMA:
            raise UserError(f"expected a gait library at {path}, found the schema {schema}")
        if version != VERSION:
            expected = f"expected version {VERSION} of the gait library, found {version}"
            raise UserError(f"{path}: {expected}; {_REMAKE}")
        for name in (*_NAMES, *ORIGIN, *OUTCOME):
            if name not in attributes and name not in group:
                expected = f"expected {name!r} in the gait library, found none"
                raise UserError(f"{path}: {expected}; {_REMAKE}")
        return cls(_Stored(group), attributes)

    def __len__(self) -> int:
        """Number of gaits."""
        return len(self.velocities)

    @property
    def velocities(self) -> np.ndarray:
        """Commanded velocities (G, 3): vx, vy [m/s], yaw rate [rad/s]."""
        return self.arrays["velocities"]

    @cached_property
    def constraints(self) -> tuple[str, ...]:
        """Names along the second axis of ``residuals``."""
        return tuple(str(name) for name in self.arrays[CONSTRAINT])

    @cached_property
    def holes(self) -> tuple[Hole, ...]:
        """Velocities whose gait did not converge."""
        return tuple(from_dict(list[Hole], self.attributes["holes"]))

    @cached_property
    def robot(self) -> Mechanism:
        """Robot of the gaits: lengths, masses, limits."""
        return from_dict(Mechanism, self.attributes["robot"])

    @property
    def dynamics(self) -> str:
        """Dynamics of the gaits: of the ``prismatic`` leg or of the virtual ``knee``."""
        return self.attributes["dynamics"]

    @property
    def kinematic_map(self) -> str:
        """Variant of eq. 1 that converted the samples: ``exact`` or ``paper``."""
        return self.attributes["kinematic_map"]

    @property
    def cost_unit(self) -> str:
        """Unit of ``arrays["cost"]``."""
        return self.attributes["cost_unit"]

    @cached_property
    def mesh(self) -> VelocityMesh:
        """Weights of the gaits at any velocity."""
        return VelocityMesh.of(self.velocities)

    @cached_property
    def straight(self) -> "GaitLibrary":
        """The gaits whose yaw rate is nearest to zero: what maps over vx and vy show."""
        rates = self.mesh.yaw_rate
        if len(rates) == 1:
            return self
        rate = rates[np.abs(rates).argmin()]
        gaits = self.velocities[:, 2] == rate
        arrays = {name: self.arrays[name][gaits] for name in (*ARRAYS, *COORDINATES)}
        holes = [hole for hole in self.attributes["holes"] if hole["yaw_rate"] == rate]
        arrays[CONSTRAINT] = self.arrays[CONSTRAINT]
        return GaitLibrary(arrays, {**self.attributes, "holes": holes})

    def find(self, vx: float, vy: float, yaw_rate: float = 0.0) -> int:
        """Index of the gait of a velocity [m/s, rad/s].

        Raises:
            UserError: names the nearest velocity, or what was violated if it is a hole.
        """
        velocity = (vx, vy, yaw_rate)
        distance, text = distances(self.velocities, velocity), velocity_text(velocity)
        index = int(distance.argmin())
        if distance[index] <= _SAME:
            return index
        nearest = f"the nearest gait is at {velocity_text(self.velocities[index])}"
        for hole in self.holes:
            if distances(np.array([hole.velocity]), velocity)[0] <= _SAME:
                raise UserError(f"the gait {text} did not converge: {hole.reason}; {nearest}")
        raise UserError(f"expected a velocity of the library, found {text}; {nearest}")


class _Stored(Mapping[str, np.ndarray]):
    """Arrays of a Zarr group, each read on first access."""

    def __init__(self, group: zarr.Group) -> None:
        self._group: Any = group
        self._read: dict[str, np.ndarray] = {}

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self._read:  # zarr.config may set "F"
            self._read[name] = np.asarray(self._group[name][...], order="C")
        return self._read[name]

    def __iter__(self) -> Iterator[str]:
        return iter(_NAMES)

    def __len__(self) -> int:
        return len(_NAMES)
