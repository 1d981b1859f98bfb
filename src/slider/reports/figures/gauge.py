"""The gauge: levels of all axes as a radar, and the robots that pass pushes by direction."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib import colormaps
from matplotlib.figure import Figure

from slider.reports.figures.style import COLOURS, DARK, EMPTY, new_figure
from slider.reports.quantities import colour
from slider.reports.rows import Row, by

_ACROSS = 2  # maps next to each other


def draw(rows: Sequence[Row], cells: pd.DataFrame, labels: Mapping[str, str]) -> Figure:
    """A radar above, a map of pushes for each controller below; ``rows`` of the table."""
    pushed = cells[cells["axis"] == "push"]
    names = [name for name in labels if (pushed["controller"] == name).any()]
    heights = [4.2, *[3.2] * math.ceil(len(names) / _ACROSS)]
    figure = new_figure(sum(heights))
    grid = figure.add_gridspec(len(heights), _ACROSS, height_ratios=heights)
    _radar(
        figure.add_subplot(grid[0, :], projection="polar"),
        [row for row in rows if "pass_1" in row],
    )
    for index, name in enumerate(names):
        place = grid[1 + index // _ACROSS, index % _ACROSS]
        axes = figure.add_subplot(place, projection="polar")
        _pushes(axes, pushed[pushed["controller"] == name], labels[name])
    return figure


def _radar(axes, rows: Sequence[Row]) -> None:
    """Level over the axes' names, a closed line per controller."""
    names = list(by(rows, "axis"))
    angles = 2 * np.pi * np.arange(len(names)) / len(names)
    for index, (label, mine) in enumerate(by(rows, "label").items()):
        levels = [row["level"] for row in mine]
        closed = [*angles, angles[0]], [*levels, levels[0]]
        axes.plot(*closed, color=colour(index), marker="o", markersize=3, label=label)
        axes.fill(*closed, color=colour(index), alpha=0.12, linewidth=0)
    highest = sum(name.startswith("pass_") for name in rows[0])
    axes.set(ylim=(0, highest), xticks=angles, xticklabels=[n.replace("_", " ") for n in names])
    axes.set_yticks(range(2, highest + 1, 2) if highest > 2 else [1, highest])
    axes.set_rlabel_position(180 / len(names))
    axes.tick_params(axis="x", pad=6)
    axes.legend(loc="upper left", bbox_to_anchor=(1.25, 1.0))


def _pushes(axes, cells: pd.DataFrame, label: str) -> None:
    """Share of robots that pass, by direction and impulse."""
    groups = cells.groupby(["value", "direction"])
    rates = (groups["passed"].sum(min_count=1) / groups["robots"].sum()).unstack()
    impulse, direction = rates.index.to_numpy(), rates.columns.to_numpy()
    width = 2 * np.pi / len(direction)
    edges = np.append(direction, direction[0] + 2 * np.pi) - width / 2
    rings = np.concatenate([[0.0], impulse])  # a ring ends at its impulse
    colours = colormaps[COLOURS].with_extremes(bad=EMPTY)
    values = np.ma.masked_invalid(100 * rates.to_numpy())
    mesh = axes.pcolormesh(edges, rings, values, cmap=colours, vmin=0, vmax=100)
    axes.set_theta_zero_location("N")
    axes.set_yticks(impulse[1::2] if len(impulse) > 3 else impulse)
    axes.set_rlabel_position(np.degrees(width) / 2)
    axes.tick_params(axis="y", labelcolor=DARK)
    axes.set_xticks(np.radians([0, 90, 180, 270]), ["forward", "left", "backward", "right"])
    axes.grid(visible=False)
    axes.set_title(f"pushes, {label}")
    axes.figure.colorbar(mesh, ax=axes, shrink=0.7, pad=0.12, label="robots that pass [%]")
