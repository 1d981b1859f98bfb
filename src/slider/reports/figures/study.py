"""A study as a picture: learning curves above, metrics of all variants below."""

from collections.abc import Sequence
from textwrap import fill

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.lines import Line2D

from slider.core.quantities import Quantity, speed_text
from slider.reports.figures.style import LIGHT, colour, new_figure
from slider.reports.quantities import quantity

PANELS = 5
CURVES = {"success": "robots that survive a check [%]", "speed_error": "speed error [m/s]"}
_MARKERS = "os^DvPX"
_DASHES = ("-", "--", ":")
_WRAP = 22  # characters of a title in a line
_MARGIN = 0.12  # [inch]
_WIDE = 30.0  # ratio of the numbers from which on an axis is logarithmic


def draw(summary: pd.DataFrame, curves: pd.DataFrame) -> Figure:
    """Dots are means, bars reach from the least to the greatest run; bands do so for curves.

    ``summary`` is that of :func:`slider.reports.study.summarise`; ``curves`` are the checks of
    trainings, by variant, seed and samples, and may be empty.
    """
    summary = summary.dropna(subset="metric")
    labels = dict(zip(summary["variant"], summary["label"], strict=True))
    metrics = summary["metric"].unique()[:PANELS]
    speeds = np.sort(summary["speed"].dropna().unique())
    above = 0.0 if curves.empty else 2.8  # [inch]
    below = 1.2 + max(0.22, 0.1 * len(speeds)) * len(labels)
    figure = new_figure(above + below)
    figure.set_layout_engine("constrained", w_pad=_MARGIN)
    heights = [height for height in (above, below) if height]
    parts = figure.subfigures(len(heights), 1, squeeze=False, height_ratios=heights)
    *upper, lower = parts[:, 0]
    for part in upper:
        _draw_curves(part, curves, labels)
    panels = lower.subplots(1, len(metrics), sharey=True, squeeze=False)[0]
    for axes, metric in zip(panels, metrics, strict=True):
        mine = summary[summary["metric"] == metric]
        _draw_dots(axes, mine, list(labels), quantity(metric), speeds)
    names = [fill(text, 30, break_long_words=False) for text in labels.values()]
    panels[0].set_yticks(range(len(labels)), names)
    panels[0].set_ylim(len(labels) - 0.5, -0.5)
    handles = []
    for index, speed in enumerate(speeds):
        look = {"color": colour(index), "marker": _MARKERS[index % len(_MARKERS)], "markersize": 4}
        handles.append(Line2D([], [], linestyle="", label=f"{speed_text(speed)} m/s", **look))
    lower.legend(handles=handles, loc="outside lower center", ncols=7)
    return figure


def _draw_dots(
    axes: Axes, rows: pd.DataFrame, variants: Sequence[str], metric: Quantity, speeds: np.ndarray
) -> None:
    """Variants down, a mark per speed; the numbers of the reference as lines."""
    place = {name: index for index, name in enumerate(variants)}
    numbers = metric.scale * rows[["mean", "least", "greatest"]].to_numpy(float)
    numbers[~np.isfinite(numbers)] = np.nan
    for row, (mean, least, greatest) in zip(rows.itertuples(), numbers, strict=True):
        index = int(np.searchsorted(speeds, row.speed)) if row.speed == row.speed else 0
        y = place[row.variant] + min(0.22, 0.8 / len(speeds)) * (index - (len(speeds) - 1) / 2)
        if row.variant == variants[0] and len(variants) > 1:
            axes.axvline(mean, color=LIGHT, linewidth=0.7, linestyle=":")
        axes.plot([least, greatest], [y, y], color=colour(index), linewidth=0.9)
        axes.plot(mean, y, _MARKERS[index % len(_MARKERS)], color=colour(index), markersize=3.6)
    positive = numbers[numbers > 0]
    if metric.share:  # with 0 and 1 % at least
        low, high = np.nanmin([0.0, *numbers.flat]), np.nanmax([1.0, *numbers.flat])
        axes.set_xlim(low - 0.05 * (high - low), high + 0.05 * (high - low))
    elif len(positive) and not (numbers < 0).any() and positive.max() > _WIDE * positive.min():
        axes.set_xscale("log")
    if axes.get_xscale() == "linear":
        axes.locator_params(axis="x", nbins=3)
    axes.set_title(fill(metric.heading, _WRAP), fontsize=7)
    axes.grid(False, axis="y")


def _draw_curves(figure: SubFigure, curves: pd.DataFrame, labels: dict[str, str]) -> None:
    for axes, (name, title) in zip(figure.subplots(1, len(CURVES)), CURVES.items(), strict=True):
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
