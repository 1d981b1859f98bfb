"""The geometry of a model's foot: the resulting foot line, and its outline."""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

from pathlib import Path

import mujoco
import numpy as np

_SLOPE = 0.05  # surfaces with a smaller slope belong to the sole
_CORNERS = 24  # number of corners of an outline


def prepare_feet(spec: mujoco.MjSpec, ankles: set[str], folder: Path) -> set[str]:
    """Set the paths of the meshes of the feet below ``ankles``; names of those with a file."""
    paired = {name for pair in spec.pairs for name in (pair.geomname1, pair.geomname2)}
    kept = set()
    for name in ankles:
        joint = spec.joint(name)
        feet = joint.parent.find_all("geom") if joint is not None else []
        for geom in feet:
            if geom.name and geom.name in paired:
                geom.contype = 1
            if geom.type == mujoco.mjtGeom.mjGEOM_MESH and (mesh := spec.mesh(geom.meshname)):
                places = folder / (spec.compiler.meshdir or "") / mesh.file, folder / mesh.file
                found = [place for place in places if mesh.file and place.is_file()]
                if found:
                    mesh.file = str(found[0].absolute())
                    kept.add(geom.meshname)
    return kept


class Foot:
    """The colliding geoms of ``bodies``, or all of them if none collides, in a rotated frame."""

    def __init__(
        self, data: mujoco.MjData, bodies: np.ndarray, origin: np.ndarray, turn: np.ndarray
    ) -> None:
        model = self._model = data.model
        geoms = np.flatnonzero(np.isin(model.geom_bodyid, bodies))
        collides = (model.geom_contype[geoms] | model.geom_conaffinity[geoms]) != 0
        self._geoms = geoms[collides] if collides.any() else geoms
        self._places = (data.geom_xpos - origin) @ turn.T
        self._turns = turn @ data.geom_xmat.reshape(-1, 3, 3)

    def __bool__(self) -> bool:
        return self._geoms.size > 0

    def extent(self, *direction: float, round_on: np.ndarray | None = None) -> np.ndarray:
        """Farthest point (3,) [m] in a direction; rounded surfaces use that of ``round_on``."""
        unit = np.array(direction) / np.linalg.norm(direction)
        other = unit if round_on is None else round_on
        points = np.array([self._support(int(geom), unit, other) for geom in self._geoms])
        return points[(points @ unit).argmax()]

    def tilt(self) -> float:
        """Angle [rad] about y that levels the longest lower edge; 0 without a flat one."""
        angles = np.deg2rad(np.arange(-45.25, 45.5, 0.5))
        points = np.array([self.extent(np.sin(t), 0.0, -np.cos(t)) for t in angles])[:, [0, 2]]
        edges = np.diff(points, axis=0)
        lengths = np.linalg.norm(edges, axis=1)
        x, z = edges[lengths.argmax()]
        return float(np.arctan2(z, x)) if lengths.max() > 0.5 * np.ptp(points[:, 0]) else 0.0

    def line(self, ankle: np.ndarray, lateral: float = 1.0) -> dict[str, float]:
        """y of the sole's middle and its width; height, toe and heel from the ankle (3,) [m].

        ``lateral`` is 1 for a left foot, −1 for a right one, which is mirrored.
        """
        along, across, down = np.diag([_SLOPE, _SLOPE, -1.0])
        front, rear, left, right = (
            self.extent(*(way + down), round_on=down)[axis]
            for axis, way in ((0, along), (0, -along), (1, across), (1, -across))
        )
        height = ankle[2] - self.extent(*down)[2]
        ends = {"ankle_height": height, "toe": front - ankle[0], "heel": ankle[0] - rear}
        return {"y": lateral * (left + right) / 2, "width": left - right, **ends}

    def outlines(self) -> list[list[list[float]]]:
        """Convex outlines in the x-z and y-z planes [m]."""
        turns = np.linspace(0.0, 2 * np.pi, _CORNERS)[:, None]
        ways = [np.cos(turns) * side + np.sin(turns) * np.eye(3)[2] for side in np.eye(3)[:2]]
        return [
            [self.extent(*way)[[axis, 2]].round(4).tolist() for way in round_about]
            for axis, round_about in enumerate(ways)
        ]

    def _support(self, geom: int, direction: np.ndarray, round_on: np.ndarray) -> np.ndarray:
        """Support point (3,) of a geom in a direction; rounded surfaces use ``round_on``."""
        model, kinds = self._model, mujoco.mjtGeom
        turn, size = self._turns[geom], model.geom_size[geom]
        own, kind = direction @ turn, model.geom_type[geom]
        if kind == kinds.mjGEOM_MESH:
            start, mesh = model.mesh_vertadr, model.geom_dataid[geom]
            vertices = model.mesh_vert[start[mesh] : start[mesh] + model.mesh_vertnum[mesh]]
            point = vertices[(vertices @ own).argmax()]
        elif kind == kinds.mjGEOM_BOX:
            point = np.sign(own) * size
        elif kind == kinds.mjGEOM_ELLIPSOID:
            other = round_on @ turn
            point = size**2 * other / np.linalg.norm(size * other)
        elif kind == kinds.mjGEOM_CYLINDER:
            radial = own[:2] / max(float(np.linalg.norm(own[:2])), 1e-12)
            point = np.array([*size[0] * radial, np.sign(own[2]) * size[1]])
        else:  # a sphere or a capsule
            half = size[1] if kind == kinds.mjGEOM_CAPSULE else 0.0
            point = size[0] * (round_on @ turn) + [0.0, 0.0, np.sign(own[2]) * half]
        return self._places[geom] + turn @ point
