"""Forward velocity over time: a panel per command, a curve per controller."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from slider.evaluation.results import Evaluation
from slider.reports.controllers import colour, speed
from slider.reports.figures.style import DARK, new_figure

_DASHES = ("-", "--", "-.", ":")
_ROW = 2.1  # height [inch]


def draw(evaluations: Sequence[Evaluation], period: float) -> Figure:
    """Mean (line) and standard deviation (band) over survivors; ``period`` of control in s."""
    commands = sorted({one.command for one in evaluations if one.command is not None})
    labels = list(dict.fromkeys(one.label for one in evaluations))
    lines = (len(commands) + 1) // 2
    figure = new_figure(_ROW * lines + 0.4)
    panels = figure.subplots(lines, 2, sharex=True, squeeze=False)
    for axes, command in zip(panels.flat, commands, strict=False):
        for one in evaluations:
            if one.command == command and one.robots.survived.any():
                _curve(axes, one.velocity, period, labels.index(one.label))
        axes.axhline(command, color=DARK, linewidth=0.9, linestyle=(0, (4, 2)))
        axes.set_title(f"{speed(command)} m/s")
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
        axes.margins(x=0.0)
        axes.set_xlim(left=0.0)
    for axes in panels.flat[len(commands) :]:
        axes.set_axis_off()
    for axes in panels[:, 0]:
        axes.set_ylabel("velocity [m/s]")
    for axes in panels[-1]:
        axes.set_xlabel("time [s]")
    figure.align_ylabels()
    for index, label in enumerate(labels):
        panels[0, 0].plot([], [], _DASHES[index % 4], color=colour(index), label=label)
    panels[0, 0].plot([], [], color=DARK, linewidth=0.9, linestyle=(0, (4, 2)), label="command")
    handles, names = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside upper center", ncols=len(names))
    return figure


def _curve(axes: Axes, velocity: np.ndarray, period: float, index: int) -> None:
    mean, spread = velocity.T
    time, tint = period * np.arange(1, len(mean) + 1), colour(index)
    axes.fill_between(time, mean - spread, mean + spread, color=tint, alpha=0.2, linewidth=0)
    axes.plot(time, mean, _DASHES[index % 4], color=tint, linewidth=1.0)
