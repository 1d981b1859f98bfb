"""Common style of all figures, and their files; equal data give equal files.

Figures have no global state: draw on ``new_figure`` within ``style()``. Colours go from dark to
light in even steps (viridis), so that a grey print keeps their order; lines also differ in dash.
"""

from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.figure import Figure

COLOURS = "viridis"
DARK, MIDDLE, LIGHT = "#1b2a49", "#c8553d", "#9aa5b1"
EMPTY = "#e9ecef"  # where there is no gait
# Distinguishable in print, for colour-blind readers, on light and dark backgrounds.
_PALETTE = ("#2a6fc9", "#e8932c", "#2a9d74", "#b565b5", "#8b8f96", "#c4a000", "#d1495b")
WIDTH = 7.2  # of all figures [inch]
_DIGITS = 5  # of positions, in shares of the figure

_STYLE: dict[str, Any] = {
    "svg.hashsalt": "slider",  # else every file has its own random names
    "svg.fonttype": "path",
    "figure.dpi": 100,
    "font.family": "DejaVu Sans",
    "font.size": 8,
    "axes.titlesize": 8.5,
    "axes.labelsize": 8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.grid": True,
    "grid.color": "#d8dde3",
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.2,
    "legend.frameon": False,
    "legend.fontsize": 7.5,
    "xtick.labelsize": 7.5,
    "ytick.labelsize": 7.5,
}


def style() -> AbstractContextManager[None]:
    """Settings in which a figure is drawn and saved."""
    return matplotlib.rc_context(_STYLE)  # pyright: ignore[reportArgumentType]


def new_figure(height: float) -> Figure:
    """Empty figure of the common width and a height [inch], with constrained layout."""
    return Figure(figsize=(WIDTH, height), layout="constrained")


def colour(index: int) -> str:
    """Colour of the controller, or other curve, number ``index``."""
    return _PALETTE[index % len(_PALETTE)]


def legend_above(figure: Figure, *handles_and_names: Any) -> None:
    """Legend above all panels, at most three names to a line: five would be too wide."""
    figure.legend(*handles_and_names, loc="outside upper center", ncols=3)


def write_pictures(stem: Path, draw: Callable[[], Figure]) -> None:
    """Write ``stem``.svg; ``draw`` is called in the common style."""
    with style():
        figure = draw()
        for _ in range(2):  # the second layout has the sizes of the first
            figure.draw_without_rendering()
        figure.set_layout_engine("none")
        _round_layout(figure)
        figure.savefig(
            stem.with_suffix(".svg"), format="svg", metadata={"Date": None, "Creator": None}
        )


def _round_layout(figure: Figure) -> None:
    """Round positions: the layout's solver has rounding errors that differ from run to run."""
    for axes in figure.axes:
        axes.set_position(np.round(axes.get_position(original=True).bounds, _DIGITS).tolist())
    for text in figure.texts:
        text.set_position(np.round(text.get_position(), _DIGITS).tolist())
