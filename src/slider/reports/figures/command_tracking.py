"""Commanded and measured velocities over time, one curve per controller."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from slider.config.evaluation import CaseConfig
from slider.reports.controllers import colour, label
from slider.reports.figures.style import DARK, new_figure

_LABELS = ("vx [m/s]", "vy [m/s]", "yaw rate [rad/s]")


@dataclass(frozen=True)
class Trace:
    """What a controller's robots did: columns of ``slider.evaluation.segments.traces`` (S, 10)."""

    controller: str
    values: np.ndarray


def draw(traces: Sequence[Trace], case: CaseConfig, duration: float) -> Figure:
    """One panel per velocity and one for the share of robots that are up; ``duration`` in s."""
    figure = new_figure(6.4)
    panels = figure.subplots(4, 1, sharex=True, height_ratios=(1.5, 1.2, 1.2, 0.6))
    for index, trace in enumerate(traces):
        _curves(panels, trace.values, duration, index, label(trace.controller))
    for axis, axes in enumerate(panels[:3]):
        command = traces[0].values[:, axis]
        axes.plot(_times(command, duration), command, color=DARK, linewidth=0.9, label="command")
        axes.set(ylabel=_LABELS[axis], ylim=_limits(command))
    panels[3].set(ylabel="share up", ylim=(-0.08, 1.08), xlabel="time [s]", xlim=(0.0, duration))
    _mark_segments(panels, case)
    handles, names = panels[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside upper center", ncols=len(names))
    return figure


def _curves(
    panels: Sequence[Axes], values: np.ndarray, duration: float, index: int, name: str
) -> None:
    time, tint = _times(values, duration), colour(index)
    for axis in range(3):
        mean, spread = values[:, 3 + axis], values[:, 6 + axis]
        band = {"color": tint, "alpha": 0.2, "linewidth": 0}
        panels[axis].fill_between(time, mean - spread, mean + spread, **band)
        panels[axis].plot(time, mean, color=tint, label=name)
    panels[3].plot(time, values[:, 9], color=tint)


def _limits(command: np.ndarray) -> tuple[float, float]:
    """Range around the command; what a falling robot does beyond it is cut off."""
    low, high = float(command.min()), float(command.max())
    margin = 0.5 * max(high - low, 0.4)
    return low - margin, high + margin


def _times(values: np.ndarray, duration: float) -> np.ndarray:
    """Ends of the control steps [s]."""
    return duration * np.arange(1, len(values) + 1) / len(values)


def _mark_segments(panels: Sequence[Axes], case: CaseConfig) -> None:
    for axes in panels:
        axes.grid(visible=False, axis="x")
        for segment in case.segments[1:]:
            axes.axvline(segment.time, color="#b8c0c9", linewidth=0.5, zorder=0)
    for segment in case.segments:
        name = segment.name.replace("_", " ")
        place = (segment.time, 1.02)
        at = panels[0].get_xaxis_transform()
        panels[0].text(*place, f" {name}", transform=at, rotation=28, fontsize=6.5, va="bottom")
