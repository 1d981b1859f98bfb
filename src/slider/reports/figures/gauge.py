"""The gauge: levels of all axes as a radar, and the robots that pass pushes by direction."""

import math
from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib import colormaps
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from slider.reports.figures.style import COLOURS, DARK, EMPTY, colour, new_figure

_ACROSS = 2  # maps next to each other
_ARCS = 8  # straight pieces of an arc


def draw(frame: pd.DataFrame, cells: pd.DataFrame, labels: Mapping[str, str]) -> Figure:
    """A radar above, a map of pushes for each controller below; ``frame`` of the table."""
    pushed = cells[cells["axis"] == "push"].groupby("controller", sort=False)
    heights = [4.2, *[3.2] * math.ceil(len(pushed) / _ACROSS)]
    figure = new_figure(sum(heights))
    grid = figure.add_gridspec(len(heights), _ACROSS, height_ratios=heights)
    axes = figure.add_subplot(grid[0, :], projection="polar")
    _radar(axes, frame[frame["axis"].isin(cells["axis"])])
    figure.legend(loc="outside upper center", ncols=_ACROSS)
    for index, (name, mine) in enumerate(pushed):
        place = grid[1 + index // _ACROSS, index % _ACROSS]
        axes = figure.add_subplot(place, projection="polar")
        _pushes(axes, mine, labels[str(name)])
    return figure


def pass_rates(cells: pd.DataFrame, keys: list[str]) -> pd.Series:
    """Share of all robots of the cells of a key that pass; NaN where these were not simulated."""
    counts = cells.groupby(keys)[["passed", "robots"]].sum(min_count=1)
    return counts["passed"] / counts["robots"]


def _radar(axes, frame: pd.DataFrame) -> None:
    """Level over the axes' names, a closed line per controller."""
    names = list(frame["axis"].unique())
    angles = 2 * np.pi * np.arange(len(names)) / len(names)
    for index, (label, mine) in enumerate(frame.groupby("label", sort=False)):
        levels = mine["level"].to_list()
        closed = [*angles, angles[0]], [*levels, levels[0]]
        axes.plot(*closed, color=colour(index), marker="o", markersize=3, label=label)
        axes.fill(*closed, color=colour(index), alpha=0.12, linewidth=0)
    highest = sum(name.startswith("pass_") for name in frame)
    axes.set(ylim=(0, highest), xticks=angles, xticklabels=[n.replace("_", " ") for n in names])
    axes.set_yticks(range(2, highest + 1, 2) if highest > 2 else [1, highest])
    axes.set_rlabel_position(180 / len(names))
    for text, angle in zip(axes.get_xticklabels(), angles, strict=True):
        side = round(np.cos(angle), 9)
        text.set_horizontalalignment("left" if side > 0 else "right" if side < 0 else "center")


def _pushes(axes, cells: pd.DataFrame, label: str) -> None:
    """Share of robots that pass, by direction and impulse."""
    rates = 100 * pass_rates(cells, ["value", "direction"]).unstack()
    impulse, directions = rates.index.to_numpy(), len(rates.columns)
    width = 2 * np.pi / directions
    edges = np.linspace(0.0, 2 * np.pi, _ARCS * directions + 1) - width / 2  # from forward on
    rings = np.concatenate([[0.0], impulse])  # a ring ends at its impulse
    colours = colormaps[COLOURS].with_extremes(bad=EMPTY)
    values = np.ma.masked_invalid(np.repeat(rates.to_numpy(), _ARCS, axis=1))
    mesh = axes.pcolormesh(edges, rings, values, cmap=colours, vmin=0, vmax=100)
    axes.set_theta_zero_location("N")
    axes.set_yticks(impulse[1::2] if len(impulse) > 3 else impulse)
    axes.set_rlabel_position(np.degrees(width) / 2)
    axes.set_axisbelow(False)
    for text in axes.get_yticklabels():
        text.set(color=DARK, path_effects=[withStroke(linewidth=2, foreground="white")])
    axes.set_xticks(np.radians([0, 90, 180, 270]), ["forward", "left", "backward", "right"])
    axes.grid(visible=False)
    axes.set_title(f"pushes, {label}")
    axes.figure.colorbar(mesh, ax=axes, shrink=0.7, pad=0.12, label="robots that pass [%]")
