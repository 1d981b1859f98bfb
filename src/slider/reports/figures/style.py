"""One look for all figures, and files that are the same whenever the data are.

Figures have no global state: draw on ``new_figure`` within ``style()``. Colours go from dark to
light in even steps (viridis), so that a grey print keeps their order; lines also differ in dash.
"""

from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.figure import Figure

COLOURS = "viridis"
DARK, MIDDLE, LIGHT = "#1b2a49", "#c8553d", "#9aa5b1"
EMPTY = "#e9ecef"  # where there is no gait
WIDTH = 7.2  # of all figures [inch]

_STYLE: dict[str, Any] = {
    "svg.hashsalt": "slider",  # else every file has its own random names
    "svg.fonttype": "path",
    "figure.dpi": 100,
    "savefig.dpi": 160,
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
    "image.cmap": COLOURS,
}


def style() -> AbstractContextManager[None]:
    """Settings in which a figure is drawn and saved."""
    return matplotlib.rc_context(_STYLE)  # pyright: ignore[reportArgumentType]


def new_figure(height: float) -> Figure:
    """Empty figure of the common width and a height [inch], laid out by constraints."""
    return Figure(figsize=(WIDTH, height), layout="constrained")


def save(figure: Figure, path: Path) -> None:
    """Write SVG or PNG, by the file's ending, without dates or versions in it."""
    suffix = path.suffix.lstrip(".")
    metadata = {"svg": {"Date": None, "Creator": None}, "png": {"Software": None}}[suffix]
    with style():
        figure.savefig(path, format=suffix, metadata=metadata)
