"""Gaits: limit cycles, and postures over a walk."""

from collections.abc import Sequence

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from slider.library.blend import blend
from slider.library.reader import GaitLibrary
from slider.reports.figures.style import COLOURS, DARK, LIGHT, MIDDLE, new_figure
from slider.robot.kinematics import foot_ends, leg_points, rotation_from_quaternion
from slider.robot.names import LEG_GAIT_JOINTS, NUM_JOINTS

CYCLES_CAPTION = """\
Position against velocity of the left leg's joints over one walk (two steps), one closed curve per
forward velocity, straight ahead; the right leg's are the same, reflected. Solid: stance and swing;
dotted: the jump of the velocity at a touchdown. The last panel is the roll about the foot line,
the one coordinate that no drive holds. Similar velocities have similar cycles: `slider library
show` says by how much they differ.
"""

_CYCLES = 9
_PHASE = np.linspace(0.0, 1.0, 101)


def draw_cycles(library: GaitLibrary) -> Figure:
    """Five driven joints and the roll of the stance foot."""
    chosen = forward_gaits(library, _CYCLES)
    speeds = library.velocities[chosen, 0]
    scale = Normalize(0.0, max(float(speeds.max()) * 1.1, 0.1))  # not up to the lightest yellow
    colours = ScalarMappable(scale, COLOURS)
    figure = new_figure(4.6)
    panels = figure.subplots(2, 3)
    for index in chosen:
        gait = blend(library, *library.velocities[index])
        colour = colormaps[COLOURS](scale(float(gait.velocity[0])))
        steps = [gait.joints(step, _PHASE) for step in range(2)]
        for column, axes in enumerate(panels.flat[:LEG_GAIT_JOINTS]):
            _closed_curve(axes, [(q[:, column], v[:, column]) for q, v in steps], colour)
        left, right = gait.roll[..., :2].swapaxes(1, 2)
        _closed_curve(panels.flat[-1], [left, -right], colour)  # for the world's signs
    for axes, joint in zip(panels.flat, library.robot.geometry.leg_joints, strict=True):
        unit = "m" if joint == "slide" and library.robot.geometry.knee is None else "rad"
        axes.set(title=joint.replace("_", " "), xlabel=f"[{unit}]", ylabel=f"[{unit}/s]")
    panels.flat[-1].set(title="roll of stance foot", xlabel="[rad]", ylabel="[rad/s]")
    bar = figure.colorbar(colours, ax=panels, pad=0.01, aspect=40, ticks=speeds, format="%.2g")
    bar.set_label("commanded forward velocity [m/s]")
    return figure


def forward_gaits(library: GaitLibrary, count: int) -> np.ndarray:
    """Indices of at most ``count`` gaits straight ahead, evenly spread, slowest to fastest.

    Straight ahead is the leftward velocity nearest to zero that the library has.
    """
    vx, vy, _ = library.velocities.T
    straight = np.flatnonzero(np.abs(vy) == np.abs(vy).min())
    # One row: where −0.05 and 0.05 are equally near, the first of them.
    straight = straight[vy[straight] == vy[straight[0]]]
    ordered = straight[np.argsort(vx[straight])]
    wanted = np.linspace(vx[ordered[0]], vx[ordered[-1]], count)
    return ordered[np.unique(np.abs(vx[ordered] - wanted[:, None]).argmin(axis=1))]


def _closed_curve(axes: Axes, pieces: Sequence, colour: object) -> None:
    """Position and velocity (N,) in each step."""
    for (x, y), (next_x, next_y) in zip(pieces, [*pieces[1:], pieces[0]], strict=True):
        axes.plot(x, y, color=colour, linewidth=1.0)
        axes.plot([x[-1], next_x[0]], [y[-1], next_y[0]], ":", color=colour, linewidth=0.7)


TILES_CAPTION = """\
The prismatic robot (after eq. 1) from its right side over one walk, at several forward velocities;
each tile moves along with the base, and the marks on the ground, 0.1 m apart, stand still. Light:
left leg; dark: right leg, the upper foot at its top; filled: the foot that stands. The fourth and
the fifth tile of a row are the two sides of a touchdown: the same posture, the other stance foot.
"""

_ROWS = 5
_HALF_WIDTH, _TILE_TOP = 0.52, 1.24  # of a tile [m]
# The torso's outline in the base frame [m], as large as in the simulation.
_TORSO = np.array([[-0.07, 0, -0.01], [0.07, 0, -0.01], [0.07, 0, 0.11], [-0.07, 0, 0.11]])
_HIP, _ANKLE, _TOP, _BACK, _FRONT = range(5)


def draw_walks(library: GaitLibrary) -> Figure:
    """One row per velocity, time goes to the right.

    Four tiles per step: its start, one third, two thirds and its end.
    """
    chosen, per_step = forward_gaits(library, _ROWS), library.arrays["time"].shape[1] // 2
    within = [round(share * (per_step - 1) / 3) for share in range(4)]
    samples = [step * per_step + sample for step in range(2) for sample in within]
    figure = new_figure(1.2 * len(chosen) + 0.1)
    panels = figure.subplots(len(chosen), len(samples), squeeze=False)
    for row, index in zip(panels, chosen, strict=True):
        _draw_tiles(row, library, int(index), samples)
        row[0].set_ylabel(f"{library.velocities[index, 0]:.2f} m/s")
    return figure


def _draw_tiles(
    row: Sequence[Axes], library: GaitLibrary, gait: int, samples: Sequence[int]
) -> None:
    """Tiles of one gait, with the time below each.

    In world x and z: the left leg behind in light, the right leg in front in dark. Marks on the
    ground stand still in the world.
    """
    arrays, geometry = library.arrays, library.robot.geometry
    base, joints = arrays["base"][gait, samples], arrays["samples"][gait, samples, :NUM_JOINTS]
    rotation, place = rotation_from_quaternion(base[:, 3:7]), base[:, None, None, :3]
    legs = place + leg_points(geometry, rotation, joints)
    feet = place + foot_ends(geometry, rotation, joints)
    torsos = base[:, None, :3] + _TORSO @ rotation.swapaxes(1, 2)
    stance = arrays["contact"][gait, samples].argmax(axis=1)
    for k, (axes, x) in enumerate(zip(row, base[:, 0].tolist(), strict=True)):
        low, high = x - _HALF_WIDTH, x + _HALF_WIDTH
        axes.plot([low, high], [0, 0], color="black", linewidth=0.8)
        for mark in np.arange(np.ceil(low / 0.1), np.floor(high / 0.1) + 1) * 0.1:
            axes.plot([mark, mark - 0.02], [0, -0.03], color="black", linewidth=0.5)
        for leg, colour in enumerate((LIGHT, DARK)):
            _draw_leg(axes, legs[k, leg], feet[k, leg], colour, 2 + 2 * leg, stance[k] == leg)
        torso = torsos[k][:, [0, 2]]
        axes.add_patch(Polygon(torso, facecolor="white", edgecolor=DARK, zorder=3))
        axes.set(xlim=(low, high), ylim=(-0.05, _TILE_TOP), aspect="equal", xticks=[], yticks=[])
        axes.grid(visible=False)
        axes.spines[:].set_visible(False)
        axes.set_xlabel(f"{arrays['time'][gait, samples[k]]:.2f} s", labelpad=1)


def _draw_leg(
    axes: Axes, points: np.ndarray, foot: np.ndarray, colour: str, order: float, loaded: bool
) -> None:
    """Points (5, 3): hip, ankle, top and upper foot; foot (2, 3): heel and toe [m]."""
    x, z = points[:, 0], points[:, 2]
    axes.plot(x[[_ANKLE, _TOP]], z[[_ANKLE, _TOP]], color=colour, linewidth=2.2, zorder=order)
    axes.plot(x[[_BACK, _FRONT]], z[[_BACK, _FRONT]], color=colour, linewidth=1.2, zorder=order)
    axes.plot(x[_HIP], z[_HIP], "o", color=colour, markersize=4.5, zorder=order)
    look = {"facecolor": MIDDLE if loaded else "white", "edgecolor": colour, "linewidth": 0.9}
    shape = np.array([points[_ANKLE], *foot])[:, [0, 2]]
    axes.add_patch(Polygon(shape, joinstyle="round", zorder=order + 0.5, **look))
