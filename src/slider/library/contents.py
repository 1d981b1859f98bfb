"""A whole gait library in memory: all arrays by name, holes, and the robot it was made for."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from slider.config.convert import from_dict
from slider.config.robot import Mechanism
from slider.core.errors import UserError
from slider.library.lookup import open_library
from slider.library.mesh import VelocityMesh
from slider.library.schema import ARRAYS, ATTRIBUTES, CONSTRAINT, GAIT_COORDINATES

_SAME = 1e-6  # velocities closer than this are one [m/s]


@dataclass(frozen=True)
class Hole:
    """A velocity [m/s] without a gait; ``residuals`` are the violated constraints, worst first."""

    vx: float
    vy: float
    status: str
    iterations: int
    max_violation: float
    residuals: Mapping[str, float]


@dataclass(frozen=True)
class LibraryContents:
    """A gait library.

    Attributes:
        arrays: name → values, gaits along the first axis; see ``docs/reference/gait-library.md``.
        constraints: names along the second axis of ``residuals``.
        holes: velocities whose gait did not converge.
        robot, kinematic_map: what the gaits were made for and with (eq. 1, variant).
        cost_unit: unit of ``arrays["cost"]``.
    """

    arrays: Mapping[str, np.ndarray]
    constraints: tuple[str, ...]
    holes: tuple[Hole, ...]
    robot: Mechanism
    kinematic_map: str
    cost_unit: str

    @classmethod
    def load(cls, path: Path) -> "LibraryContents":
        """Read the Zarr store at ``path``.

        Raises:
            UserError: not a gait library, of another version, or without one of its parts.
        """
        group = open_library(path)
        names = (*ARRAYS, *GAIT_COORDINATES)
        missing = [name for name in (*names, CONSTRAINT) if name not in group]
        missing += [name for name in ATTRIBUTES if name not in group.attrs]
        if missing:
            raise UserError(
                f"{path}: expected {missing[0]!r} in the gait library, found none; "
                "make it anew with `snakemake -j2 gait_library`"
            )
        holes, robot, variant, cost_unit = (group.attrs[name] for name in ATTRIBUTES)
        return cls(
            arrays={name: _values(group[name]) for name in names},
            constraints=tuple(str(name) for name in _values(group[CONSTRAINT])),
            holes=tuple(from_dict(list[Hole], holes)),
            robot=from_dict(Mechanism, robot),
            kinematic_map=str(variant),
            cost_unit=str(cost_unit),
        )

    def __len__(self) -> int:
        """Number of gaits."""
        return len(self.velocities)

    @property
    def velocities(self) -> np.ndarray:
        """Commanded vx, vy (G, 2) [m/s]."""
        return self.arrays["velocities"]

    @cached_property
    def mesh(self) -> VelocityMesh:
        """Weights of the gaits at any command."""
        return VelocityMesh.of(self.velocities)

    def find(self, vx: float, vy: float) -> int:
        """Index of the gait of a velocity [m/s].

        Raises:
            UserError: names the nearest velocity, or what was violated if it is a hole.
        """
        distance = np.hypot(self.velocities[:, 0] - vx, self.velocities[:, 1] - vy)
        index = int(distance.argmin())
        if distance[index] <= _SAME:
            return index
        near_vx, near_vy = self.velocities[index]
        nearest = f"the nearest gait is at ({near_vx:g}, {near_vy:g}) m/s"
        for hole in self.holes:
            if np.hypot(hole.vx - vx, hole.vy - vy) <= _SAME:
                why = f"{hole.status}, {violations(hole)}"
                raise UserError(f"the gait ({vx:g}, {vy:g}) m/s did not converge: {why}; {nearest}")
        found = f"found ({vx:g}, {vy:g}) m/s"
        raise UserError(f"expected a velocity of the library, {found}; {nearest}")


def violations(hole: Hole) -> str:
    """The three worst violated constraints of a hole by name."""
    return ", ".join(f"{name} {value:.1e}" for name, value in [*hole.residuals.items()][:3])


def _values(array: Any) -> np.ndarray:
    return np.asarray(array[...])
