"""Processor time of each gait's optimisation; a measurement, so no stage draws it."""

import numpy as np
from matplotlib.figure import Figure

from slider.library.reader import GaitLibrary
from slider.reports.figures.maps import VelocityMap, draw_map
from slider.reports.figures.style import DARK, new_figure


def draw(library: GaitLibrary, times: np.ndarray) -> Figure:
    """Map of the times (G,) [s], and how many gaits took how long."""
    figure = new_figure(3.6)
    top, bottom = figure.subplots(2, 1, height_ratios=(1, 1.3))
    draw_map(top, library, VelocityMap("solve time", times, "s of processor"))
    bottom.hist(times[np.isfinite(times)], bins=30, color=DARK, rwidth=0.9)
    bottom.set(xlabel="processor time of IPOPT [s]", ylabel="gaits")
    return figure


def caption(times: np.ndarray) -> str:
    """The times in numbers."""
    known = times[np.isfinite(times)]
    return (
        f"Processor time of IPOPT from a cold start, without imports and building the problem: "
        f"median {np.median(known):.2f} s, greatest {known.max():.2f} s, {known.sum():.0f} s in "
        f"all for {len(known)} gaits. Measured when each gait was computed, with whatever else "
        "the machine was doing; grey cells: not known.\n"
    )
