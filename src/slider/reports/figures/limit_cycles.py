"""Limit cycles of the joints for forward velocities, as in the paper's figure."""

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from slider.library.blend import Gait, blend
from slider.library.reader import GaitLibrary
from slider.reports.figures.style import COLOURS, new_figure
from slider.robot.names import JOINTS, LEG_JOINTS

CAPTION = """\
Position against velocity of the left leg's joints over one walk (two steps), one closed curve per
forward velocity, straight ahead; the right leg's are the same, reflected. Solid: stance and swing;
dotted: the jump of the velocity at a touchdown. The last panel is the roll about the foot line,
the one coordinate that no drive holds. Similar velocities have similar cycles: `smoothness.md`
says by how much they differ.
"""

_GAITS = 9
_PHASE = np.linspace(0.0, 1.0, 101)
_SHOWN = LEG_JOINTS[:5]

Pieces = list[tuple[np.ndarray, np.ndarray]]


def draw(library: GaitLibrary) -> Figure:
    """Five driven joints and the roll of the stance foot."""
    chosen = forward_gaits(library, _GAITS)
    speeds = library.velocities[chosen, 0]
    scale = Normalize(0.0, max(float(speeds.max()) * 1.1, 0.1))  # not up to the lightest yellow
    colours = ScalarMappable(scale, COLOURS)
    figure = new_figure(4.6)
    panels = figure.subplots(2, 3)
    for index in chosen:
        gait = blend(library, *library.commands[index])
        colour = colormaps[COLOURS](scale(float(gait.command[0])))
        for axes, joint in zip(panels.flat, _SHOWN, strict=False):
            _closed_curve(axes, _joint(gait, joint), colour)
        _closed_curve(panels.flat[-1], _roll(gait), colour)
    for axes, joint in zip(panels.flat, _SHOWN, strict=False):
        unit = "m" if joint == "slide" else "rad"
        axes.set(title=joint.replace("_", " "), xlabel=f"[{unit}]", ylabel=f"[{unit}/s]")
    panels.flat[-1].set(title="roll of stance foot", xlabel="[rad]", ylabel="[rad/s]")
    bar = figure.colorbar(colours, ax=panels, pad=0.01, aspect=40, ticks=speeds, format="%.2g")
    bar.set_label("commanded forward velocity [m/s]")
    return figure


def forward_gaits(library: GaitLibrary, count: int) -> np.ndarray:
    """Indices of at most ``count`` gaits straight ahead, evenly spread, slowest to fastest.

    Straight ahead is the leftward velocity nearest to zero that the library has.
    """
    vx, vy = library.velocities.T
    straight = np.flatnonzero(np.abs(vy) == np.abs(vy).min())
    # One row: where −0.05 and 0.05 are equally near, the first of them.
    straight = straight[vy[straight] == vy[straight[0]]]
    ordered = straight[np.argsort(vx[straight])]
    wanted = np.linspace(vx[ordered[0]], vx[ordered[-1]], count)
    return ordered[np.unique(np.abs(vx[ordered] - wanted[:, None]).argmin(axis=1))]


def _joint(gait: Gait, joint: str) -> Pieces:
    """Position and velocity (N,) of a joint of the left leg in each step."""
    column = JOINTS.index(f"left_{joint}")
    steps = [gait.joints(step, _PHASE) for step in range(2)]
    return [(position[:, column], velocity[:, column]) for position, velocity in steps]


def _roll(gait: Gait) -> Pieces:
    """Roll and its rate in each step; the second step is reflected, for the world's signs."""
    return [(sign * gait.roll[step, :, 0], sign * gait.roll[step, :, 1]) for step, sign in _SIGNS]


_SIGNS = ((0, 1.0), (1, -1.0))


def _closed_curve(axes: Axes, pieces: Pieces, colour: object) -> None:
    ends = zip(pieces, [*pieces[1:], pieces[0]], strict=True)
    for (x, y), (next_x, next_y) in ends:
        axes.plot(x, y, color=colour, linewidth=1.0)
        axes.plot([x[-1], next_x[0]], [y[-1], next_y[0]], ":", color=colour, linewidth=0.7)
