"""Terrain of robots: kinds and levels, and the boxes near their feet that simulate the ground.

Every robot has its own infinite ground, given by formulas. Its MuJoCo model has the floor's plane
and a few boxes, which are moved under the feet in each control step. A foot therefore touches a
slope, a step or a tile exactly, at five points, and rough ground at its tangent plane.
"""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

import math
from collections.abc import Sequence
from typing import TypeAlias

import mujoco
import numpy as np

from slider.config.env import TerrainConfig
from slider.config.robot import RobotConfig
from slider.env.height_field import CELL, DEPTH, TILES, UnevenGround, adapt_to_terrain
from slider.robot import names
from slider.robot.kinematics import foot_ends, rotation_from_quaternion, yaw_of

# Increment per level.
SLOPE = math.radians(1.25)  # [rad]
STEP, RISE, GAP = 0.012, 0.01, 0.015  # height of a step and of a stair, width of a gap [m]
TILE, WAVE = 0.008, 0.004  # heights of tiles and of rough ground lie within ± this [m]

TREAD, STAIRS = 0.3, 12  # depth of a stair [m], their number
BOARD, BOARDS = 0.4, 60  # from gap to gap [m], number of boards
PLATFORM = (0.3, 0.6)  # level ground ahead of a start on steps, stairs and boards [m]

_BOXES = 8  # of a robot: bars ahead and behind, or four tiles under each foot
_HIDDEN = -50.0  # height of boxes that are not in use [m]
_THICK = 0.15  # half the thickness of a box [m]
_LONG = 1.5  # half the width of bars, and half the length of the first and the last [m]
_PATCH = (0.14, 0.14)  # half the size of the tangent plane under a foot [m]
_ALONG = np.linspace(0.0, 1.0, 5)  # points along a foot that must be above the ground
_LOOK_AHEAD = 0.01  # boxes lie where feet will be after this time, half of 20 ms [s]
DRAWS = 5  # uniform numbers per robot: level, side, start of the bars, position (2)


def magnitude(kind: str, level: float) -> str:
    """Magnitude of a level of a kind, as text."""
    if kind.startswith("slope"):
        return f"{math.degrees(SLOPE) * level:.3g}°"
    scale = {"step": STEP, "stairs": RISE, "gaps": GAP, "tiles": TILE, "rough": WAVE}
    sign = "± " if kind in ("tiles", "rough") else ""
    return f"{sign}{100 * scale.get(kind.partition('_')[0], 0.0) * level:.3g} cm"


def add_ground(spec: mujoco.MjSpec) -> None:
    """Add the boxes of the ground to a robot's spec, and let contact sensors count them."""
    floor = spec.geom(names.FLOOR)
    for index in range(_BOXES):
        box = spec.worldbody.add_geom(
            name=f"ground_{index}", type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.1, 0.1, _THICK]
        )
        box.pos = [0.0, 0.0, _HIDDEN]
        box.contype, box.conaffinity = floor.contype, floor.conaffinity
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_MIDPHASE  # its tree does not move
    for side in names.SIDES:
        _add_foot_spheres(spec, side)
    for sensor in spec.sensors:
        if sensor.objname == names.FLOOR:
            sensor.objtype, sensor.objname = mujoco.mjtObj.mjOBJ_BODY, "world"


def _add_foot_spheres(spec: mujoco.MjSpec, side: str) -> None:
    """Let a row of spheres touch the ground instead of the foot's capsule, which they fill.

    MuJoCo's contact points of a capsule on a box jump along the capsule: a light foot would rock.
    """
    line, body = spec.geom(names.foot(side)), spec.body(names.foot(side))
    start, end = np.array(line.fromto[:3]), np.array(line.fromto[3:])
    for share in _ALONG:
        stud = body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[line.size[0], 0, 0], mass=0.0)
        stud.pos = (1 - share) * start + share * end
        stud.contype, stud.conaffinity = line.contype, line.conaffinity
        stud.friction, stud.priority = line.friction, line.priority
        stud.solref, stud.solimp = line.solref, line.solimp
    line.contype, line.conaffinity = 0, 0
    sensor = spec.sensor(f"{side}_foot_force")
    sensor.reftype, sensor.refname = mujoco.mjtObj.mjOBJ_BODY, body.name


class Terrain:
    """Grounds of N robots in their models.

    The ``models`` have the boxes of :func:`add_ground`; ``table`` (64, 64) has heights of tiles in
    [-1, 1].

    Attributes:
        levels: (N,).
        ground: under the robots.
    """

    def __init__(
        self,
        config: TerrainConfig,
        robot: RobotConfig,
        models: Sequence[mujoco.MjModel],
        table: np.ndarray,
    ) -> None:
        self._config, self._geometry, count = config, robot.geometry, len(models)
        self.kinds = np.array([config.kinds[i % len(config.kinds)] for i in range(count)])
        self.levels = np.full(count, config.level.lower)
        slope, place = np.zeros((2, count, 2))
        rise, gap, start, bars, tiles, waves = np.zeros((6, count))
        tread = np.ones(count)
        self.ground = UnevenGround(slope, rise, tread, gap, start, bars, tiles, waves, place, table)
        self._uneven = np.flatnonzero(self.kinds != "flat")
        self._views = [_Views(model) for model in models]
        everyone, origin = np.arange(count), np.zeros((count, 2))
        self._place_boxes(everyone, self.ground, origin, np.stack([origin, origin], axis=1))

    def grade(self, passed: np.ndarray, fell: np.ndarray) -> None:
        """In a curriculum, raise the levels of robots that ``passed`` (N,), lower on a fall."""
        if not self._config.curriculum:
            return
        levels = self.levels + (1.0 * passed - 1.0 * fell)
        self.levels[:] = levels.clip(self._config.level.lower, None)

    @property
    def mean_level(self) -> float:
        """Mean level of the robots that are not on flat ground; 0 without any."""
        if not len(self._uneven):
            return 0.0
        return float(self.levels[self._uneven].clip(None, self._config.level.upper).mean())

    def described(self, robot: int) -> str:
        """Kind and level of a robot's ground, in words."""
        kind = str(self.kinds[robot])
        return f"{kind.replace('_', ' ')}, {magnitude(kind, self.levels[robot])}"

    def speeds(self, share: float) -> np.ndarray:
        """Factors (N,) on velocities: ``share`` on uneven ground, 1 on flat ground."""
        return np.where(self.kinds == "flat", 1.0, share)

    def begin(self, index: np.ndarray, qpos: np.ndarray, uniform: np.ndarray) -> np.ndarray:
        """Give robots ``index`` new grounds and boxes, by uniform numbers (n, ``DRAWS``) in [0, 1).

        Returns:
            Positions (n, 19): legs and feet are adapted to the ground, the lowest foot is as high
            above it as in ``qpos`` (n, 19) above a plane.
        """
        self._draw(index, uniform)
        place = self.ground.of(index)
        qpos = self._stand(place, qpos)
        self._place_boxes(index, place, qpos[:, :2], self._ends(qpos).mean(axis=2)[..., :2])
        return qpos

    def _draw(self, index: np.ndarray, uniform: np.ndarray) -> None:
        bounds, level = self._config.level, self.levels[index]
        drawn = bounds.lower + (bounds.upper - bounds.lower) * uniform[:, 0]
        # In a curriculum, robots beyond the highest level get a random level.
        there = self._config.curriculum & (level <= bounds.upper)
        self.levels[index] = np.where(there, level, drawn)
        level, kinds, ground = self.levels[index], self.kinds[index], self.ground

        def of(*wanted: str) -> np.ndarray:
            return level * np.isin(kinds, wanted)

        side = np.where(uniform[:, 1] < 0.5, -1.0, 1.0)
        along = of("slope_up") - of("slope_down")
        ground.slope[index] = np.tan(SLOPE * np.stack([along, side * of("slope_across")], axis=1))
        stairs, boards = np.isin(kinds, ["stairs_up", "stairs_down"]), kinds == "gaps"
        single = np.isin(kinds, ["step_up", "step_down"])
        ground.rise[index] = STEP * (of("step_up") - of("step_down"))
        ground.rise[index] += RISE * (of("stairs_up") - of("stairs_down"))
        ground.gap[index] = GAP * of("gaps")
        ground.tread[index] = np.where(boards, BOARD, TREAD)
        ground.bars[index] = 1.0 * single + STAIRS * stairs + BOARDS * boards
        least, most = PLATFORM
        ground.start[index] = least + (most - least) * uniform[:, 2]
        ground.tiles[index], ground.waves[index] = TILE * of("tiles"), WAVE * of("rough")
        ground.place[index] = TILES * CELL * uniform[:, 3:5]

    def _ends(self, qpos: np.ndarray) -> np.ndarray:
        """Lowest points of heels and toes (n, 2, 2, 3) [m]."""
        rotation = rotation_from_quaternion(qpos[:, 3:7])
        ends = foot_ends(self._geometry, rotation, qpos[:, 7:])
        return ends + qpos[:, None, None, :3]

    def _stand(self, ground: UnevenGround, qpos: np.ndarray) -> np.ndarray:
        """Adapt the legs to the ground, and keep the lowest foot's height above the ground."""
        before = self._ends(qpos)
        yaw = yaw_of(rotation_from_quaternion(qpos[:, 3:7]))
        qpos = qpos.copy()
        qpos[:, 7:] += adapt_to_terrain(
            ground, before.mean(axis=2)[..., :2], yaw, self._geometry, qpos[:, 7:]
        )
        line = _ALONG[:, None]
        ends = self._ends(qpos)
        points = (1 - line) * ends[:, :, :1] + line * ends[:, :, 1:]
        above = points[..., 2] - ground.height(points[..., :2])
        qpos[:, 2] += before[..., 2].min(axis=(1, 2)) - above.min(axis=(1, 2))
        return qpos

    def follow(self, base: np.ndarray, feet: np.ndarray, velocities: np.ndarray) -> None:
        """Put the boxes under the middles of feet (N, 2, 2) [m] with ``velocities`` [m/s].

        ``base`` (N, 2) [m] are positions of the bases.
        """
        index = self._uneven
        feet = feet[index] + _LOOK_AHEAD * velocities[index]
        self._place_boxes(index, self.ground.of(index), base[index], feet)

    def _place_boxes(
        self, index: np.ndarray, ground: UnevenGround, base: np.ndarray, feet: np.ndarray
    ) -> None:
        arrays = (*_floors(ground), *_boxes_near(ground, base, feet))
        for robot, *values in zip(index, *arrays, strict=True):
            self._views[robot].set(*values)


class _Views:
    """Views of the arrays that position a model's floor and the boxes, the geoms after it."""

    def __init__(self, model: mujoco.MjModel) -> None:
        floor = model.geom(names.FLOOR).id
        boxes = slice(floor + 1, floor + 1 + _BOXES)
        assert model.geom(floor + 1).name == "ground_0"
        self._places = (
            *(model.geom_pos[floor], model.geom_quat[floor]),
            *(model.geom_pos[boxes], model.geom_quat[boxes], model.geom_size[boxes]),
        )
        self._reach, self._bound = model.geom_aabb[boxes, 3:], model.geom_rbound[boxes]
        self._shortcuts = model.geom_sameframe[floor : boxes.stop]

    def set(self, *values: np.ndarray) -> None:
        """Floor's position and quaternion; positions, quaternions, half sizes of the boxes."""
        for place, value in zip(self._places, values, strict=True):
            place[:] = value
        half = self._reach[:] = values[-1]
        self._bound[:] = np.sqrt((half * half).sum(axis=1))
        self._shortcuts[:] = 0  # mj_setConst assumes that geoms in the world's frame stay there


def _floors(ground: UnevenGround) -> tuple[np.ndarray, np.ndarray]:
    """Position (N, 3) and quaternion (N, 4) of the plane: the slope, or below everything else."""
    boxed = (ground.bars > 0) | (ground.tiles > 0) | (ground.waves > 0)
    position = np.zeros((len(boxed), 3))
    lowest = np.minimum(ground.rise * ground.bars, 0.0) - DEPTH
    position[:, 2] = np.where(boxed, lowest, 0.0)
    return position, _quaternion_to(ground.slope)


def _quaternion_to(slope: np.ndarray) -> np.ndarray:
    """Quaternions (..., 4) that turn the vertical to the normal of planes of slopes (..., 2)."""
    normal = np.concatenate([-slope, np.ones_like(slope[..., :1])], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    half = np.sqrt(0.5 * (1.0 + normal[..., 2]))
    zero = np.zeros_like(half)
    return np.stack(
        [half, -0.5 * normal[..., 1] / half, 0.5 * normal[..., 0] / half, zero], axis=-1
    )


Boxes: TypeAlias = tuple[np.ndarray, ...]
"""Positions, quaternions and half sizes (N, K, 3 or 4) of K boxes each [m]."""


def _boxes_near(ground: UnevenGround, base: np.ndarray, feet: np.ndarray) -> Boxes:
    """The ground near bases (N, 2) and feet (N, 2, 2) [m] as boxes."""
    count = len(base)
    boxes = (
        np.tile([0.0, 0.0, _HIDDEN], (count, _BOXES, 1)),
        np.tile([1.0, 0.0, 0.0, 0.0], (count, _BOXES, 1)),
        np.full((count, _BOXES, 3), 0.1),
    )
    for place, used, near in (
        (_bars, ground.bars > 0, base),
        (_tiles, ground.tiles > 0, feet),
        (_tangents, ground.waves > 0, feet),
    ):
        rows = np.flatnonzero(used)
        if len(rows):
            part = tuple(values[rows] for values in boxes)
            place(part, ground.of(rows), near[rows])
            for values, new in zip(boxes, part, strict=True):
                values[rows] = new
    return boxes


def _bars(boxes: Boxes, ground: UnevenGround, base: np.ndarray) -> None:
    """The bars around the base, one for each box."""
    position, _, half = boxes
    bars, tread, start = ground.bars[:, None], ground.tread[:, None], ground.start[:, None]
    here = np.floor((base[:, :1] - start) / tread) + 1.0 - _BOXES // 2
    number = np.clip(here, 0.0, np.maximum(bars + 1.0 - _BOXES, 0.0)) + np.arange(_BOXES)
    low = start + (number - 1.0) * tread + ground.gap[:, None]
    high = start + number * tread
    low = np.where(number == 0, np.minimum(base[:, :1], high) - 2 * _LONG, low)
    high = np.where(number == bars, np.maximum(base[:, :1], low) + 2 * _LONG, high)
    position[..., 0], position[..., 1] = 0.5 * (low + high), base[:, 1:]
    position[..., 2] = np.where(number <= bars, ground.rise[:, None] * number, _HIDDEN) - _THICK
    half[..., 0], half[..., 1], half[..., 2] = 0.5 * (high - low), _LONG, _THICK


def _tiles(boxes: Boxes, ground: UnevenGround, feet: np.ndarray) -> None:
    """The four tiles nearest to the middle of each foot."""
    near = np.floor(feet / CELL)[:, :, None] + [[0, 0], [0, 1], [1, 0], [1, 1]]  # (N, 2, 4, 2)
    cells = near.reshape(len(feet), _BOXES, 2)
    top = ground.tile(cells)
    shared = (near[:, 1, :, None] == near[:, 0, None]).all(-1).any(-1)  # near both feet: one box
    top[:, _BOXES // 2 :][shared] = _HIDDEN
    boxes[0][..., :2], boxes[0][..., 2] = CELL * cells, top - _THICK
    boxes[2][:] = [0.5 * CELL, 0.5 * CELL, _THICK]


def _tangents(boxes: Boxes, ground: UnevenGround, feet: np.ndarray) -> None:
    """The tangent plane under the middle of each foot."""
    position, quaternion, half = (values[:, : len(names.SIDES)] for values in boxes)
    quaternion[:] = _quaternion_to(ground.gradient(feet))
    rotation = rotation_from_quaternion(quaternion.reshape(-1, 4)).reshape(*feet.shape[:2], 3, 3)
    top = np.concatenate([feet, ground.height(feet)[..., None]], axis=-1)
    position[:] = top - _THICK * rotation[..., 2]
    half[:] = [*_PATCH, _THICK]
