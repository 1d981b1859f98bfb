"""Heights of the ground under the robots by formula: flat, uneven, or as a sensor shows it."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from slider.config.robot import Geometry
from slider.core.arrays import Array, asarray, namespace, zeros
from slider.robot import names
from slider.robot.kinematics import extend_leg, turn_to_heading

DEPTH = 0.5  # of a gap [m]
CELL = 0.25  # edge of a tile [m]
TILES = 64  # number of tiles after which their heights repeat
_FADE = 0.3  # rough ground is level up to this distance from its origin, full from twice that [m]
# Wave vectors [rad/m] of rough ground; their amplitudes add up to 1.
_WAVES = 2 * math.pi * np.array([[0.8, 0.15], [-0.3, 0.7], [0.6, -0.9], [1.1, 0.6]])
_SHARES = np.array([0.4, 0.3, 0.2, 0.1])
_WHOLE = ("table", "flat")  # shared by all robots


@dataclass(frozen=True)
class FlatGround:
    """A plane at z = 0."""

    flat: bool = True

    def height(self, points: Array, gaps: bool = True) -> Array:
        """Zeros (N, ...) for points (N, ..., 2)."""
        return zeros(points.shape[:-1], points)

    def gradient(self, points: Array) -> Array:
        """Zeros (N, ..., 2) for points (N, ..., 2)."""
        return zeros(points.shape, points)

    def of(self, robots: Array) -> "FlatGround":
        """Itself: the same under all robots."""
        return self


FLAT = FlatGround()


@dataclass(frozen=True)
class UnevenGround:
    """Grounds of N robots: the sum of a plane, bars across the x axis, square tiles and waves.

    Robots walk along the world's x axis. Bars are steps, stairs or boards: the top of bar j of n is
    at j times the rise, from start + (j − 1) tread + gap to start + j tread. The first and the last
    bar are infinitely long; between bars are gaps.

    Attributes:
        slope: (N, 2) rise over run along x and y.
        rise, tread, gap, start: (N,) of the bars [m].
        bars: (N,) number of bars besides the first; 0: none.
        tiles: (N,) amplitude of the tiles' heights [m].
        waves: (N,) amplitude of the waves [m].
        place: (N, 2) position of the robot's origin in the table of tiles and in the waves [m].
        table: (64, 64) heights of tiles, uniform in [-1, 1].
    """

    slope: Array
    rise: Array
    tread: Array
    gap: Array
    start: Array
    bars: Array
    tiles: Array
    waves: Array
    place: Array
    table: Array
    flat: bool = False

    def height(self, points: Array, gaps: bool = True) -> Array:
        """Heights (N, ...) [m] at points (N, ..., 2) of the world [m].

        Without ``gaps`` the ground continues level across them, where no foot should step.
        """
        plane = (self._wide(self.slope, points) * points).sum(-1)
        depth = DEPTH if gaps else 0.0
        tiles = self.tile(namespace(points).floor(points / CELL + 0.5))
        return plane + self._bar(points, depth) + tiles + self._field(points)[0]

    def gradient(self, points: Array) -> Array:
        """Rise over run (N, ..., 2) at points (N, ..., 2), ignoring vertical faces."""
        return self._wide(self.slope, points) + self._field(points)[1]

    def of(self, robots: Array) -> "UnevenGround":
        """The ground under ``robots`` (n,) of the N."""
        rows = {name: values[robots] for name, values in vars(self).items() if name not in _WHOLE}
        return UnevenGround(**rows, table=self.table)

    def _wide(self, values: Array, points: Array) -> Array:
        """Values (N, ...) of the robots, reshaped to broadcast over their points (N, ..., 2)."""
        return values.reshape(len(values), *(1,) * (points.ndim - 2), *values.shape[1:])

    def _bar(self, points: Array, depth: float) -> Array:
        xp, values = namespace(points), (self.rise, self.tread, self.gap, self.start, self.bars)
        rise, tread, gap, start, bars = (self._wide(value, points) for value in values)
        ahead = points[..., 0] - start
        number = (xp.floor(ahead / tread) + 1.0).clip(0.0, None)
        number = xp.minimum(number, bars)
        hole = (number > 0) & (ahead - (number - 1.0) * tread < gap)
        return rise * number - depth * hole

    def tile(self, cells: Array) -> Array:
        """Heights (N, ...) [m] of tiles by index (N, ..., 2); the nine around the origin: 0."""
        xp = namespace(cells)
        place = xp.floor(self._wide(self.place, cells) / CELL)
        index = xp.asarray(cells + place, dtype=xp.int64) % TILES
        level = (abs(cells) <= 1.0).all(-1)
        return self._wide(self.tiles, cells) * self.table[index[..., 0], index[..., 1]] * ~level

    def _field(self, points: Array) -> tuple[Array, Array]:
        """Heights (N, ...) and gradients (N, ..., 2) of the waves, which fade in from the start."""
        xp, waves = namespace(points), self._wide(self.waves, points)
        vectors, shares = asarray(_WAVES, points), asarray(_SHARES, points)
        phases = (points + self._wide(self.place, points)) @ vectors.T
        distance = xp.sqrt((points**2).sum(-1) + 1e-12)
        share = ((distance - _FADE) / _FADE).clip(0.0, 1.0)
        fade = share * share * (3.0 - 2.0 * share)
        steep = 6.0 * share * (1.0 - share) / _FADE / distance
        wave = waves * (xp.sin(phases) @ shares)
        gradient = waves[..., None] * ((xp.cos(phases) * shares) @ vectors)
        return fade * wave, fade[..., None] * gradient + (steep * wave)[..., None] * points


Ground: TypeAlias = FlatGround | UnevenGround


@dataclass(frozen=True)
class ScannedGround:
    """Ground as a height sensor shows it around estimated positions of N robots.

    Attributes:
        ground: under the robots.
        centre: (N, 2) estimated position of the base [m].
        place: (N, 2) point of the ground that the sensor reads at ``centre`` [m].
        turn: (N,) true minus estimated heading [rad].
        lift: (N,) added to heights: estimated minus true height of the base, plus the bias [m].
        level: (N,) height returned at points without a reading [m].
        noise, drop_out: standard deviation [m], share of points without a reading.
        normal, uniform: return random numbers (N, columns) of this reading, given the columns.
    """

    ground: Ground
    centre: Array
    place: Array
    turn: Array
    lift: Array
    level: Array
    noise: float
    drop_out: float
    normal: Callable[[int], Array]
    uniform: Callable[[int], Array]
    flat: bool = False

    def height(self, points: Array, gaps: bool = True) -> Array:
        """Heights (N, P) [m] at points (N, P, 2) [m]."""
        away = turn_to_heading(points - self.centre[:, None], -self.turn[:, None])
        heights = self.ground.height(away + self.place[:, None], gaps) + self.lift[:, None]
        count, xp = points.shape[1], namespace(points)
        heights = heights + self.noise * asarray(self.normal(count), points)
        seen = asarray(self.uniform(count), points) >= self.drop_out
        return xp.where(seen, heights, self.level[:, None])


def adapt_to_terrain(
    ground: Ground, feet: Array, yaw: Array, geometry: Geometry, joints: Array
) -> Array:
    """Change of joint positions (N, 12) that adapts a pose for level ground to this ground.

    A leg is shortened by the height of the ground under its foot above the mean under both feet; an
    ankle is turned by the slope along the heading.

    Args:
        ground, geometry: ground under the robots; geometry of the legs.
        feet, yaw: middles of the feet (N, 2, 2) [m] and headings (N,) [rad].
        joints: positions (N, 12) to be changed.
    """
    heights, result = ground.height(feet, gaps=False), zeros((len(yaw), names.NUM_JOINTS), yaw)
    mean, gradient = heights.mean(-1), ground.gradient(feet)
    for leg in range(len(names.SIDES)):
        steep = turn_to_heading(gradient[:, leg], yaw)[:, 0]
        first, longer = leg * names.LEG_SIZE, mean - heights[:, leg]
        driven = slice(first, first + names.LEG_GAIT_JOINTS)
        result[:, driven] = extend_leg(geometry, joints, leg, longer)
        turn = namespace(yaw).arctan(steep) / geometry.ankle_direction[1]
        result[:, first + names.ANKLE] -= turn
    return result
