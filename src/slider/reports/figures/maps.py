"""Quantities of the gaits over the commanded velocities."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from slider.library import measures
from slider.library.reader import GaitLibrary
from slider.reports.figures.style import COLOURS, MIDDLE, new_figure

_CAPTION = """\
One cell per gait; a red cross marks a velocity whose gait did not converge, and white is outside
the grid. Gaits that turn are left out. The cost is that of the optimisation (`gait.cost`). Torque
and voltage are the greatest of all motors over the walk, as shares of the motor's torque limit and
of its torque-speed line.
"""


def caption(library: GaitLibrary) -> str:
    """What a cell is."""
    return _CAPTION


def draw_map(axes: Axes, library: GaitLibrary, title: str, values: np.ndarray, unit: str) -> None:
    """One coloured cell per gait (G,), a cross at each hole, a colour bar with the unit."""
    vx, vy = library.mesh.vx, library.mesh.vy
    x, y, _ = library.velocities.T
    cells = np.ma.masked_all((len(vy), len(vx)))
    cells[np.searchsorted(vy, y), np.searchsorted(vx, x)] = values
    look = {"cmap": COLOURS, "edgecolor": "white", "linewidth": 0.4}
    mesh = axes.pcolormesh(_edges(vx), _edges(vy), cells, **look)
    axes.set(xlabel="commanded forward velocity [m/s]", ylabel="leftward\n[m/s]")
    axes.grid(visible=False)
    for hole in library.holes:
        axes.plot(hole.vx, hole.vy, "x", color=MIDDLE, markersize=4, markeredgewidth=1.2)
    bar = axes.figure.colorbar(mesh, ax=axes, pad=0.01, aspect=8)
    bar.set_label(unit)
    bar.outline.set_visible(False)  # type: ignore[reportCallIssue]
    axes.set_title(title, loc="left")


def draw(library: GaitLibrary) -> Figure:
    """Cost, times, base height and use of the drives, one below the other."""
    torque, voltage = (100 * shares.max(axis=1) for shares in measures.motor_shares(library))
    slides = library.robot.geometry.knee is None
    maps = (
        ("cost", library.arrays["cost"], library.cost_unit),
        ("step time", library.arrays["step_time"].mean(axis=1), "s"),
        ("base height", library.arrays["base"][:, :, 2].mean(axis=1), "m"),
        ("motor torque", torque, "% of limit"),
        ("motor voltage", voltage, "% of the bus"),
        ("slide speed", measures.slide_speed(library), "m/s" if slides else "rad/s"),
    )
    figure = new_figure(1.25 * len(maps) + 0.3)
    panels = figure.subplots(len(maps), 1, sharex=True)
    for axes, item in zip(panels, maps, strict=True):
        draw_map(axes, library, *item)
        axes.label_outer()
    return figure


def _edges(axis: np.ndarray) -> np.ndarray:
    """Edges (N + 1,) of cells around sorted values (N,), halfway between neighbours."""
    half = np.diff(axis, append=axis[-1:] + (np.ptp(axis[-2:]) or 0.05)) / 2
    return np.concatenate([axis[:1] - half[:1], axis + half])
