"""The prismatic robot over one walk, from its right side, at several forward velocities."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from slider.config.robot import Geometry
from slider.library.reader import GaitLibrary
from slider.reports.figures.limit_cycles import forward_gaits
from slider.reports.figures.style import DARK, LIGHT, MIDDLE, new_figure
from slider.robot.kinematics import foot_ends, leg_points, rotation_from_quaternion
from slider.robot.names import NUM_JOINTS

CAPTION = """\
The prismatic robot (after eq. 1) from its right side over one walk, at several forward velocities;
each tile moves along with the base, and the marks on the ground, 0.1 m apart, stand still. Light:
left leg; dark: right leg, the upper foot at its top; filled: the foot that stands. The fourth and
the fifth tile of a row are the two sides of a touchdown: the same posture, the other stance foot.
"""

_ROWS = 5
_HALF_WIDTH, _TILE_TOP = 0.52, 1.24  # of a tile [m]
# The torso's outline in the base frame (x, z) [m], as large as in the simulation.
_TORSO = np.array([[-0.07, -0.01], [0.07, -0.01], [0.07, 0.11], [-0.07, 0.11]])
_HIP, _ANKLE, _TOP, _BACK, _FRONT = range(5)


@dataclass(frozen=True)
class Posture:
    """Points of one posture in the world [m].

    Attributes:
        base: (3,); rotation: (3, 3) base to world.
        legs: (2, 5, 3) hip, ankle, top and upper foot of the left and the right leg.
        feet: (2, 2, 3) heel and toe.
        stance: 0 where the left foot stands, 1 where the right one does.
    """

    base: np.ndarray
    rotation: np.ndarray
    legs: np.ndarray
    feet: np.ndarray
    stance: int


def draw(library: GaitLibrary) -> Figure:
    """One row per velocity, time goes to the right."""
    chosen = forward_gaits(library, _ROWS)
    columns = tile_samples(library)
    figure = new_figure(1.2 * len(chosen) + 0.1)
    panels = figure.subplots(len(chosen), len(columns), squeeze=False)
    for row, index in zip(panels, chosen, strict=True):
        draw_tiles(row, library, int(index))
        row[0].set_ylabel(f"{library.velocities[index, 0]:.2f} m/s")
    return figure


def tile_samples(library: GaitLibrary) -> list[int]:
    """Samples of four tiles per step: its start, one third, two thirds and its end."""
    per_step = library.arrays["time"].shape[1] // 2
    within = [round(share * (per_step - 1) / 3) for share in range(4)]
    return [step * per_step + sample for step in range(2) for sample in within]


def draw_tiles(row: Sequence[Axes], library: GaitLibrary, gait: int) -> None:
    """Draw the tiles of one gait, with the time below each."""
    samples = tile_samples(library)
    times = library.arrays["time"][gait, samples]
    for axes, posture, time in zip(row, postures(library, gait, samples), times, strict=True):
        _tile(axes, posture)
        axes.set_xlabel(f"{time:.2f} s", labelpad=1)


def _tile(axes: Axes, posture: Posture) -> None:
    x = float(posture.base[0])
    draw_ground(axes, x - _HALF_WIDTH, x + _HALF_WIDTH)
    draw_posture(axes, posture)
    axes.set(xlim=(x - _HALF_WIDTH, x + _HALF_WIDTH), ylim=(-0.05, _TILE_TOP), aspect="equal")
    axes.set(xticks=[], yticks=[])
    axes.grid(visible=False)
    axes.spines[:].set_visible(False)


def postures(library: GaitLibrary, gait: int, samples: list[int]) -> list[Posture]:
    """Postures of a gait of the library at some of its samples."""
    geometry: Geometry = library.robot.geometry
    base = library.arrays["base"][gait, samples]
    joints = library.arrays["samples"][gait, samples, :NUM_JOINTS]
    rotation = rotation_from_quaternion(base[:, 3:7])
    legs = base[:, None, None, :3] + leg_points(geometry, rotation, joints)
    feet = base[:, None, None, :3] + foot_ends(geometry, rotation, joints)
    stance = library.arrays["contact"][gait, samples].argmax(axis=1)
    values = zip(base[:, :3], rotation, legs, feet, stance, strict=True)
    return [Posture(*posture) for posture in values]


def draw_posture(axes: Axes, posture: Posture) -> None:
    """Draw in world x and z: the left leg behind in light, the right leg in front in dark."""
    _leg(axes, posture, 0, LIGHT)
    torso = posture.base + np.stack([_TORSO[:, 0], 0 * _TORSO[:, 0], _TORSO[:, 1]], 1) @ (
        posture.rotation.T
    )
    axes.add_patch(Polygon(torso[:, [0, 2]], facecolor="white", edgecolor=DARK, zorder=3))
    _leg(axes, posture, 1, DARK)


def draw_ground(axes: Axes, low: float, high: float, spacing: float = 0.1) -> None:
    """Ground from x = low to high, with marks that stand still in the world [m]."""
    axes.plot([low, high], [0, 0], color="black", linewidth=0.8)
    for x in np.arange(np.ceil(low / spacing), np.floor(high / spacing) + 1) * spacing:
        axes.plot([x, x - 0.02], [0, -0.03], color="black", linewidth=0.5)


def _leg(axes: Axes, posture: Posture, leg: int, colour: str) -> None:
    order = 2 + 2 * leg
    points, foot = posture.legs[leg], posture.feet[leg]
    x, z = points[:, 0], points[:, 2]
    axes.plot(x[[_ANKLE, _TOP]], z[[_ANKLE, _TOP]], color=colour, linewidth=2.2, zorder=order)
    axes.plot(x[[_BACK, _FRONT]], z[[_BACK, _FRONT]], color=colour, linewidth=1.2, zorder=order)
    axes.plot(x[_HIP], z[_HIP], "o", color=colour, markersize=4.5, zorder=order)
    shape = np.array([points[_ANKLE], *foot])[:, [0, 2]]
    loaded = posture.stance == leg
    axes.add_patch(
        Polygon(
            shape,
            facecolor=MIDDLE if loaded else "white",
            edgecolor=colour,
            linewidth=0.9,
            joinstyle="round",
            zorder=order + 0.5,
        )
    )
