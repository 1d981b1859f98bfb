"""Controllers: results over the speed, velocity over time, protocols, and learning curves."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from slider.config.evaluation import EvaluationConfig
from slider.core.quantities import speed_text
from slider.evaluation.results import Evaluation
from slider.evaluation.segments import profile_of
from slider.reports.figures.style import DARK, colour, legend_above, new_figure
from slider.training.results import Training

_LEAST_ERROR = 1e-4  # shown [m²/s²]: a robot that stands has nearly none
_DASHES = ("-", "--", "-.", ":")
_MARGIN = 0.15  # [inch]; the layout does not see the labels of the logarithmic axis
_LABELS = ("vx [m/s]", "vy [m/s]", "yaw rate [rad/s]")
_MARKERS = "os^vDPX"
_CHECKS = {  # column of the checks → axis
    "success": "share that survives",
    "tracked": "share that tracks",
    "speed_error": "speed error [m/s]",
    "flight": "flight share",
    "value": "score",
}
_SHOWN_TERMS = 7  # of the reward, the largest


def draw_tradeoff(frame: pd.DataFrame) -> Figure:
    """Settled error over cost of transport, a point for each command [m/s]."""
    figure = new_figure(3.6)
    axes = figure.subplots()
    for index, (label, mine) in enumerate(frame.groupby("label", sort=False)):
        mine = mine[np.isfinite(mine["mse_steady"])].sort_values("speed")
        place = mine[["cost_of_transport", "mse_steady"]]
        look = _look(index) | {"marker": _MARKERS[index % len(_MARKERS)], "markersize": 4}
        axes.plot(*place.to_numpy().T, label=label, **look)
        for speed, point in zip(mine["speed"], place.to_numpy(), strict=True):
            near = {"textcoords": "offset points", "xytext": (4, 2), "color": look["color"]}
            axes.annotate(speed_text(speed), point, fontsize=6, **near)
    axes.set(xlabel="cost of transport", ylabel="velocity MSE [m²/s²]")
    if axes.lines and np.isfinite(frame["mse_steady"]).any():
        axes.set(xscale="log", yscale="log")
    ticks = [0.4, 0.6, 0.8, 1.0, 1.5, 2.0, 3.0]
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.minorticks_off()
    legend_above(figure)
    figure.set_layout_engine("constrained", w_pad=_MARGIN)
    return figure


def draw_speeds(frame: pd.DataFrame) -> Figure:
    """Three panels over a common axis, of the rows of the protocol's table."""
    figure = new_figure(6.2)
    speeds, rates, errors = figure.subplots(3, 1, sharex=True, height_ratios=(1.9, 1.0, 1.0))
    ends = [frame["speed"].min(), frame["speed"].max()]
    speeds.plot(ends, ends, color=DARK, linewidth=0.8, linestyle=(0, (1, 2)), label="command")
    for index, (label, mine) in enumerate(frame.groupby("label", sort=False)):
        mine, look = mine.sort_values("speed"), _look(index)
        command, spread = mine["speed"], mine["mean_velocity_spread"]
        _band(speeds, command, mine["mean_velocity"], spread, index, str(label))
        rates.plot(command, mine["success_rate"], **look)
        rates.plot(command, mine["tracking_rate"], ".", color=colour(index), markersize=4)
        errors.plot(command, _finite(mine["mse_steady"]), **look)
    speeds.set(ylabel="mean speed [m/s]")
    speeds.legend(loc="upper left")
    rates.set(ylabel="share of robots", ylim=(-0.04, 1.04))
    errors.set(ylabel="MSE [m²/s²]", yscale="log", xlabel="commanded speed [m/s]")
    figure.align_ylabels()
    figure.set_layout_engine("constrained", w_pad=_MARGIN)
    errors.set_ylim(bottom=_LEAST_ERROR)
    errors.yaxis.set_major_formatter("{x:g}")
    return figure


def _finite(values: pd.Series) -> pd.Series:
    return values.where(np.isfinite(values))


def _band(axes: Axes, x, mean, spread, index: int, label: str = "") -> None:
    """Mean (N,) as a line and a standard deviation (N,) as a band, of a controller."""
    low, high, look = mean - spread, mean + spread, _look(index)
    axes.fill_between(x, low, high, color=look["color"], alpha=0.2, linewidth=0)
    axes.plot(x, mean, label=label or None, **look)


def _look(index: int) -> dict[str, Any]:
    return {"color": colour(index), "linestyle": _DASHES[index % len(_DASHES)]}


def draw_segments(evaluations: Sequence[Evaluation], protocol: EvaluationConfig) -> Figure:
    """One panel per velocity and one for the share of robots that are up."""
    (case,), duration = profile_of(protocol).cases, protocol.duration
    figure = new_figure(6.4)
    panels = figure.subplots(4, 1, sharex=True, height_ratios=(1.5, 1.2, 1.2, 0.6))
    traces = [one.traces for one in evaluations if one.traces is not None]
    time = duration * np.arange(1, len(traces[0]) + 1) / len(traces[0])  # ends of control steps
    for index, (one, trace) in enumerate(zip(evaluations, traces, strict=True)):
        for axis in range(3):
            _band(panels[axis], time, trace[:, 3 + axis], trace[:, 6 + axis], index, one.label)
        panels[3].plot(time, trace[:, 9], **_look(index))
    for axis, axes in enumerate(panels[:3]):
        command = traces[0][:, axis]
        axes.plot(time, command, color=DARK, linewidth=0.9, label="command")
        # The motion of falling robots beyond it is cut off.
        low, high = float(command.min()), float(command.max())
        margin = 0.5 * max(high - low, 0.4)
        axes.set(ylabel=_LABELS[axis], ylim=(low - margin, high + margin))
    panels[3].set(ylabel="share up", ylim=(-0.08, 1.08), xlabel="time [s]", xlim=(0.0, duration))
    for axes in panels:
        axes.grid(visible=False, axis="x")
        for segment in case.segments[1:]:
            axes.axvline(segment.time, color="#b8c0c9", linewidth=0.5, zorder=0)
    above = {"transform": panels[0].get_xaxis_transform(), "rotation": 28, "va": "bottom"}
    for segment in case.segments:
        name = segment.name.replace("_", " ")
        panels[0].text(segment.time, 1.02, f" {name}", fontsize=6.5, **above)
    legend_above(figure, *panels[0].get_legend_handles_labels())
    return figure


def draw_tracking(frame: pd.DataFrame) -> Figure:
    """Mean (line) and standard deviation (band) over survivors, of the rows of the report."""
    commands, labels = np.sort(frame["speed"].unique()), frame["label"].unique()
    lines = (len(commands) + 1) // 2
    figure = new_figure(2.1 * lines + 0.4)
    panels = figure.subplots(lines, 2, sharex=True, squeeze=False)
    for axes, command in zip(panels.flat, commands, strict=False):
        for index, label in enumerate(labels):
            mine = frame[(frame["speed"] == command) & (frame["label"] == label)]
            mean, spread = mine["mean_velocity"], mine["mean_velocity_spread"]
            _band(axes, mine["time"], mean, spread, index, str(label))
        axes.axhline(command, color=DARK, linewidth=0.9, linestyle=(0, (4, 2)), label="command")
        axes.set_title(f"{speed_text(command)} m/s")
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
    legend_above(figure, *panels[0, 0].get_legend_handles_labels())
    return figure


def draw_training(training: Training) -> Figure:
    """Periodic checks above; below, where recorded, the largest terms of the reward."""
    checks, curve = training.checks, training.curve
    names = [name for name in _CHECKS if checks[name].notna().any()]
    terms = [name for name in curve if "reward" in name.partition("/")[0].lower() and "/" in name]
    figure = new_figure(4.2 if terms else 1.9)
    above, *below = figure.subfigures(2 if terms else 1, 1, squeeze=False)[:, 0]
    panels = above.subplots(1, len(names), squeeze=False)[0]
    for axes, name in zip(panels, names, strict=True):
        axes.plot(checks["iteration"], checks[name], ".-", color=DARK)
        axes.set(title=_CHECKS[name], xlabel="iteration")
        if name == "value" and (checks[name] > 0).all():
            axes.set_yscale("log")
        else:
            axes.set_ylim(bottom=0.0)
    for part in below:
        axes = part.subplots()
        sizes = {name: float(np.nanmean(np.abs(curve[name]))) for name in terms}
        shown = sorted(terms, key=lambda name: -sizes[name])[:_SHOWN_TERMS]
        for index, name in enumerate(shown):
            label = name.partition("/")[2].replace("_", " ")
            axes.plot(curve["iteration"], curve[name], color=colour(index), label=label)
        axes.set(xlabel="iteration", ylabel="weighted reward term")
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


_CURVES = {"success": "robots that survive a check [%]", "speed_error": "speed error [m/s]"}


def draw_curves(curves: pd.DataFrame, labels: Mapping[str, str]) -> Figure:
    """Means over the seeds of a variant; bands reach from the minimum to the maximum.

    ``curves`` are the checks of trainings, by variant, seed and samples.
    """
    figure = new_figure(2.8)
    for axes, (name, title) in zip(figure.subplots(1, len(_CURVES)), _CURVES.items(), strict=True):
        factor = 100.0 if name == "success" else 1.0
        for index, (variant, label) in enumerate(labels.items()):
            values = factor * curves[curves["variant"] == variant].set_index("samples")[name]
            groups = values.groupby(level=0)
            mean, tint, dash = groups.mean(), colour(index), _DASHES[index // 7 % len(_DASHES)]
            millions = mean.index / 1e6
            axes.plot(millions, mean, dash, color=tint, label=label, marker=".")
            axes.fill_between(millions, groups.min(), groups.max(), color=tint, alpha=0.12, lw=0)
        axes.set(title=title, xlabel="samples [million]")
        axes.set_ylim(bottom=0)
    handles, names = axes.get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=3)
    return figure
