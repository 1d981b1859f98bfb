"""The prismatic robot from its right side: torso, legs, feet."""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon

from slider.config.robot import Geometry
from slider.library.reader import GaitLibrary
from slider.reports.figures.style import DARK, LIGHT, MIDDLE
from slider.robot.kinematics import foot_ends, leg_points, rotation_from_quaternion
from slider.robot.names import NUM_JOINTS

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
