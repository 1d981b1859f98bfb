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
from slider.reports.seeds import Row, distinct, numbers, spread

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


def draw(rows: Sequence[Row], curves: Sequence[Row], labels: Mapping[str, str]) -> Figure:
    """Lines and dots are means over seeds; bands and bars reach from the least to the greatest."""
    above, below = 2.8, 1.1 + 0.3 * len(labels)  # [inch]
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
    below.legend(handles=_markers(rows), loc="outside lower center", ncols=8)
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
        samples = sorted(set(numbers(curves, "samples", variant=variant)))
        found = [spread(numbers(curves, name, variant=variant, samples=s)) for s in samples]
        mean, lower, upper = (
            np.array([np.nan if f is None else factor * getattr(f, part) for f in found])
            for part in ("mean", "lower", "upper")
        )
        x = np.array(samples) / 1e6
        axis.add_line(_line(x, mean, index, marker=".", markersize=4))
        axis.fill_between(x, lower, upper, color=colour(index), alpha=0.12, linewidth=0)
    axis.autoscale_view()
    axis.set_xlabel("samples [million]")
    axis.set_ylim(bottom=0)


def _draw_dots(axis: Axes, rows: Sequence[Row], name: str, labels: Mapping[str, str]) -> None:
    title, factor, logarithmic = DOTS[name]
    commands = distinct(rows, "command_velocity")
    for place, variant in enumerate(labels):
        for index, command in enumerate(commands):
            found = spread(numbers(rows, name, variant=variant, command_velocity=command))
            if found is None or not np.isfinite(found.mean):
                continue
            y = place + 0.22 * (index - (len(commands) - 1) / 2)
            style = {"color": colour(place), "zorder": 3}
            axis.plot([factor * found.lower, factor * found.upper], [y, y], lw=0.9, **style)
            axis.plot(factor * found.mean, y, _MARKERS[index % 7], markersize=3.6, **style)
            _draw_reference(axis, rows, name, command, y)
    if logarithmic:
        axis.set_xscale("log")
    axis.set_title(title)
    if name in _SHARES:
        axis.set_xlim(-4, 104)
    axis.set_yticks(range(len(labels)), [fill(text, _WRAP) for text in labels.values()])
    axis.set_ylim(len(labels) - 0.5, -0.5)


def _draw_reference(axis: Axes, rows: Sequence[Row], name: str, command: float, y: float) -> None:
    """A stroke at the number of the library's gait, where it has one."""
    column = f"reference_{name}"
    if column in rows[0]:
        found = spread(numbers(rows, column, command_velocity=command))
        if found is not None:
            axis.plot(found.mean, y, "|", color=DARK, markersize=5, zorder=2)


def _markers(rows: Sequence[Row]) -> list[Line2D]:
    gait = Line2D([], [], color=DARK, marker="|", linestyle="", label="the library's gait")
    return [
        Line2D([], [], color=DARK, marker=_MARKERS[i % 7], linestyle="", label=f"{speed(v)} m/s")
        for i, v in enumerate(distinct(rows, "command_velocity"))
    ] + [gait]
