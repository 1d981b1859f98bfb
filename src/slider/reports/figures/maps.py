"""Quantities of the gaits over the commanded velocities."""

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from slider.library import measures
from slider.library.reader import GaitLibrary
from slider.reports.figures.style import COLOURS, MIDDLE, new_figure

MAPS_CAPTION = """\
One cell per gait; a red cross marks a velocity whose gait did not converge, and white is outside
the grid. Gaits that turn are left out. The cost is that of the optimisation (`gait.cost`). Torque
and voltage are the greatest of all motors over the walk, as shares of the motor's torque limit and
of its torque-speed line.
"""


def draw_map(axes: Axes, library: GaitLibrary, title: str, values: np.ndarray, unit: str) -> None:
    """One coloured cell per gait (G,), a cross at each hole, a colour bar with the unit."""
    places = np.array([*library.velocities[:, :2], *((h.vx, h.vy) for h in library.holes)])
    rectangles, limits = [], []
    for axis, value, place in zip(
        (library.mesh.vx, library.mesh.vy), library.velocities[:, :2].T, places.T, strict=True
    ):
        low, high = _borders(axis)
        index, margin = np.searchsorted(axis, value), float((high - low).max()) / 2
        rectangles.append((low[index], (high - low)[index]))
        limits.append((place.min() - margin, place.max() + margin))
    (left, width), (bottom, height) = rectangles
    cells = PatchCollection(
        [Rectangle((x, y), *size) for x, y, *size in zip(left, bottom, width, height, strict=True)],
        cmap=colormaps[COLOURS],
        norm=_norm(values),
    )
    cells.set_array(values)
    cells.set(edgecolor="white", linewidth=0.4)
    axes.add_collection(cells)
    axes.set(xlabel="commanded forward velocity [m/s]", ylabel="leftward\n[m/s]")
    axes.set(xlim=limits[0], ylim=limits[1])
    axes.grid(visible=False)
    for hole in library.holes:
        axes.plot(hole.vx, hole.vy, "x", color=MIDDLE, markersize=4, markeredgewidth=1.2)
    bar = axes.figure.colorbar(cells, ax=axes, pad=0.01, aspect=8)
    bar.set_label(unit)
    bar.outline.set_visible(False)  # type: ignore[reportCallIssue]
    axes.set_title(title, loc="left")


def draw_velocity_maps(library: GaitLibrary) -> Figure:
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


def _borders(axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Half way to the neighbours, below and above each value."""
    half = np.diff(axis) / 2 if len(axis) > 1 else np.array([0.025])
    below, above = np.concatenate([half[:1], half]), np.concatenate([half, half[-1:]])
    return axis - below[: len(axis)], axis + above[: len(axis)]


def _norm(values: np.ndarray) -> Normalize:
    low, high = float(values.min()), float(values.max())
    margin = 0.01 * abs(low) if np.isclose(low, high) else 0.0  # else only rounding shows
    return Normalize(low - margin, high + margin)
