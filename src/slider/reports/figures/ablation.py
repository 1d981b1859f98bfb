"""The ablation as a picture: learning curves above, the finished policies below."""

from collections.abc import Mapping, Sequence
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import ArrayLike

from slider.reports.controllers import colour, speed
from slider.reports.figures.style import DARK, new_figure
from slider.reports.rows import Row, by, distinct

CURVES = {"success": "robots that survive a check [%]", "speed_error": "speed error [m/s]"}
# Column → title, factor, logarithmic.
DOTS = {
    "success_rate": ("success [%]\n", 100.0, False),
    "mse_steady": ("settled velocity\nMSE [m²/s²]", 1.0, True),
    "alternation": ("alternating\ntouchdowns [%]", 100.0, False),
    "flight": ("flight [%]\n", 100.0, False),
    "velocity_variance": ("variance of the\nvelocity [m²/s²]", 1.0, True),
}
_MARKERS = ("o", "s", "^", "D", "v", "P", "X")
_DASHES = ("-", "--", ":")
_COLOURS = 7
_SHARES = ("success_rate", "alternation")
_MARGIN = 0.12  # [inch]
_WRAP = 20  # characters of a label in a line
_MARKS = 5  # in a line of the legend


def draw(rows: Sequence[Row], curves: Sequence[Row], labels: Mapping[str, str]) -> Figure:
    """Lines and dots are means over seeds; bands and bars reach from the least to the greatest."""
    marks, commands = _markers(rows), len(distinct(rows, "command_velocity"))
    above, below = 2.8, 1.1 + 0.1 * max(3, commands) * len(labels)  # [inch]
    below += 0.2 * (len(marks) > _MARKS)
    figure = new_figure(above + below)
    figure.set_layout_engine("constrained", w_pad=_MARGIN)
    parts = np.asarray(figure.subfigures(2, 1, height_ratios=[above, below]))
    above, below = parts
    axes = above.subplots(1, len(CURVES))
    for axis, (name, title) in zip(axes, CURVES.items(), strict=True):
        _draw_curves(axis, curves, name, labels)
        axis.set_title(title)
    handles = [_line([], [], index, label=text) for index, text in _numbered(labels)]
    above.legend(handles=handles, loc="outside lower center", ncols=3)
    panels = below.subplots(1, len(DOTS), sharey=True)
    for axis, name in zip(panels, DOTS, strict=True):
        _draw_dots(axis, rows, name, labels)
    below.legend(handles=marks, loc="outside lower center", ncols=_MARKS)
    return figure


def _numbered(labels: Mapping[str, str]) -> list[tuple[int, str]]:
    return list(enumerate(labels.values()))


def _line(x: ArrayLike, y: ArrayLike, index: int, **settings: Any) -> Line2D:
    """A line in the look of variant ``index``."""
    dash = _DASHES[index // _COLOURS % len(_DASHES)]
    return Line2D(x, y, color=colour(index), linestyle=dash, **settings)


def _draw_curves(axis: Axes, curves: Sequence[Row], name: str, labels: Mapping[str, str]) -> None:
    factor = 100.0 if name == "success" else 1.0
    for index, variant in enumerate(labels):
        groups = by((row for row in curves if row["variant"] == variant), "samples")
        samples = sorted(groups)
        found = np.array([_spread(groups[count], name) for count in samples])
        mean, lower, upper = factor * found.T
        x = np.array(samples) / 1e6
        axis.add_line(_line(x, mean, index, marker=".", markersize=4))
        axis.fill_between(x, lower, upper, color=colour(index), alpha=0.12, linewidth=0)
    axis.autoscale_view()
    axis.set_xlabel("samples [million]")
    axis.set_ylim(bottom=0)


def _draw_dots(axis: Axes, rows: Sequence[Row], name: str, labels: Mapping[str, str]) -> None:
    title, factor, logarithmic = DOTS[name]
    commands, groups = distinct(rows, "command_velocity"), by(rows, "variant", "command_velocity")
    for place, variant in enumerate(labels):
        for index, command in enumerate(commands):
            mean, least, greatest = (factor * x for x in _spread(groups[variant, command], name))
            if not np.isfinite(mean):
                continue
            y = place + min(0.22, 0.8 / len(commands)) * (index - (len(commands) - 1) / 2)
            style = {"color": colour(place), "zorder": 3}
            axis.plot([least, greatest], [y, y], lw=0.9, **style)
            axis.plot(mean, y, _MARKERS[index % 7], markersize=3.6, **style)
            gait = groups[variant, command][0].get(f"reference_{name}", np.nan)
            if not np.isnan(gait):  # a stroke at the number of the library's gait
                axis.plot(gait, y, "|", color=DARK, markersize=5, zorder=2)
    if logarithmic:
        axis.set_xscale("log")
    axis.set_title(title)
    if name in _SHARES:
        axis.set_xlim(-4, 104)
    axis.set_yticks(range(len(labels)), [fill(text, _WRAP) for text in labels.values()])
    axis.set_ylim(len(labels) - 0.5, -0.5)


def _spread(rows: Sequence[Row], name: str) -> tuple[float, float, float]:
    """Mean, least and greatest over the seeds that have the number; NaN without any."""
    known = [row[name] for row in rows if not np.isnan(row[name])]
    if not known:
        return np.nan, np.nan, np.nan
    return float(np.mean(known)), min(known), max(known)


def _markers(rows: Sequence[Row]) -> list[Line2D]:
    gait = Line2D([], [], color=DARK, marker="|", linestyle="", label="the library's gait")
    return [
        Line2D([], [], color=DARK, marker=_MARKERS[i % 7], linestyle="", label=f"{speed(v)} m/s")
        for i, v in enumerate(distinct(rows, "command_velocity"))
    ] + [gait]
