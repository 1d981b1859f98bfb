"""Limit cycles of gaits."""

from collections.abc import Sequence

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from slider.library.blend import blend
from slider.library.reader import GaitLibrary
from slider.reports.figures.style import COLOURS, new_figure
from slider.robot.names import LEG_GAIT_JOINTS

_CAPTION = """\
Position against velocity of the left leg's joints over one walk (two steps), one closed curve per
forward velocity, straight ahead; the right leg's are the same, reflected. Solid: stance and swing;
dotted: the jump of the velocity at a touchdown. The last panel is the roll about the foot line,
the one coordinate that no drive holds. Similar velocities have similar cycles: `slider library
show` says by how much they differ.
"""

_CYCLES = 9
_PHASE = np.linspace(0.0, 1.0, 101)


def caption(library: GaitLibrary) -> str:
    """What the curves are."""
    return _CAPTION


def draw(library: GaitLibrary) -> Figure:
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
