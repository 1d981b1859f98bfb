"""Learning curves of a study's variants."""

from collections.abc import Mapping

import pandas as pd
from matplotlib.figure import Figure

from slider.reports.figures.style import colour, new_figure

CURVES = {"success": "robots that survive a check [%]", "speed_error": "speed error [m/s]"}
_DASHES = ("-", "--", ":")


def draw(curves: pd.DataFrame, labels: Mapping[str, str]) -> Figure:
    """Means over the seeds of a variant; bands reach from the least to the greatest.

    ``curves`` are the checks of trainings, by variant, seed and samples.
    """
    figure = new_figure(2.8)
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
    return figure
