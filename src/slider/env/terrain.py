"""Terrain: heights under the robots, the height field that simulates them, places on it.

A height field is one period with a margin. A robot that leaves the period is put back by one, which
it cannot notice; the world that controllers and metrics see goes on.
"""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from slider.config.env import GroundConfig
from slider.config.robot import RobotConfig
from slider.core.arrays import Array, namespace, zeros
from slider.robot import names
from slider.robot.kinematics import foot_ends, rotation_from_quaternion

if TYPE_CHECKING:  # terms read heights and are checked without a simulator
    import mujoco

_MARGIN = 1.5  # the robot's reach and its way in a control period [m]
_BASE = 0.1  # thickness of the ground below its lowest point [m]
# The field lies deeper by this and pushes within this of it [m]. Nothing then enters its prisms,
# which would push a foot between two of them sideways and let it sink in.
SKIN = 0.01
_POINTS = np.linspace(0.0, 1.0, 5)  # along a foot, which touch the ground


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


def lay(spec: "mujoco.MjSpec", config: GroundConfig, tile: np.ndarray) -> None:
    """Replace the floor of a model by a height field with the heights of one period (n, n) [m]."""
    import mujoco

    margin = int(np.ceil(_MARGIN / config.cell))
    nodes = len(tile) + 2 * margin + 1
    rows = (np.arange(nodes) - margin) % len(tile)
    heights = tile[np.ix_(rows, rows)]
    half = 0.5 * (nodes - 1) * config.cell
    lowest, highest = float(heights.min()), float(heights.max())
    field = spec.add_hfield(
        name="ground", nrow=nodes, ncol=nodes, size=[half, half, highest - lowest, _BASE]
    )
    field.userdata = heights.ravel()  # MuJoCo maps the lowest to 0, the highest to 1
    floor = spec.geom(names.FLOOR)
    floor.type = mujoco.mjtGeom.mjGEOM_HFIELD
    floor.hfieldname = field.name
    floor.pos = [0.5 * config.period, 0.5 * config.period, lowest - SKIN]
    floor.margin = SKIN
    for side in names.SIDES:
        _stud(spec, side)


def _stud(spec: "mujoco.MjSpec", side: str) -> None:
    """Let a row of spheres touch the ground in place of the foot's capsule, which they fill.

    MuJoCo finds one contact of a capsule with each triangle: a light foot would rock on it.
    """
    import mujoco

    line, body = spec.geom(names.foot(side)), spec.body(names.foot(side))
    start, end = np.array(line.fromto[:3]), np.array(line.fromto[3:])
    for share in _POINTS:
        stud = body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[line.size[0], 0, 0], mass=0.0)
        stud.pos = (1 - share) * start + share * end
        stud.contype, stud.conaffinity = line.contype, line.conaffinity
        stud.friction, stud.priority = line.friction, line.priority
    line.contype, line.conaffinity = 0, 0
    sensor = spec.sensor(f"{side}_foot_force")
    sensor.reftype, sensor.refname = mujoco.mjtObj.mjOBJ_BODY, body.name


class Terrain:
    """Where N robots are on the ground.

    Attributes:
        offset: (N, 2) place of a robot in the world minus its place on the height field [m].
        sensor_offset: (N, 2) the same for sensors, which were read before the last wrap [m].
    """

    def __init__(
        self, config: GroundConfig, robot: RobotConfig, tile: np.ndarray, count: int
    ) -> None:
        self._config, self._geometry, self._tile = config, robot.geometry, tile
        self.offset, self.sensor_offset = np.zeros((2, count, 2))

    @property
    def ground(self) -> UnevenGround:
        """The ground as it lies in the world of each robot."""
        return UnevenGround(self._tile, self._config.cell, self.offset.copy())

    def place(self, index: np.ndarray, qpos: np.ndarray, uniform: np.ndarray) -> np.ndarray:
        """Put robots ``index`` somewhere on the field by numbers (N, 2) in [0, 1).

        Returns:
            Positions (n, 19) on the field: the feet are as high above the ground as they were
            above a plane in ``qpos`` (n, 19).
        """
        qpos = qpos.copy()
        self.offset[index] = qpos[:, :2] - self._config.period * uniform[index]
        self.sensor_offset[index] = self.offset[index]
        qpos[:, 2] += self._lift(index, qpos)
        qpos[:, :2] -= self.offset[index]
        return qpos

    def _lift(self, index: np.ndarray, qpos: np.ndarray) -> np.ndarray:
        rotation = rotation_from_quaternion(qpos[:, 3:7])
        ends = foot_ends(self._geometry, rotation, qpos[:, 7:]) + qpos[:, None, None, :3]
        line = (1 - _POINTS)[:, None] * ends[:, :, :1] + _POINTS[:, None] * ends[:, :, 1:]
        points = line.reshape(len(qpos), -1, 3)
        here = UnevenGround(self._tile, self._config.cell, self.offset[index])
        above = points[..., 2] - here.height(points[..., :2])
        return points[..., 2].min(axis=1) - above.min(axis=1)

    def wrap(self, qpos: np.ndarray) -> None:
        """Put robots that left the period back by one, in place in positions (N, 19)."""
        period = self._config.period
        gone = period * np.floor(qpos[:, :2] / period)
        qpos[:, :2] -= gone
        self.sensor_offset[:] = self.offset
        self.offset += gone
