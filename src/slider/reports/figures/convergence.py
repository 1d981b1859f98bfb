"""How the optimisation ended over the grid, and how long it took, which no stage draws."""

from collections import Counter

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from slider.library.reader import GaitLibrary
from slider.reports.figures.maps import VelocityMap, draw_map
from slider.reports.figures.style import DARK, new_figure

_FLOOR = 1e-12  # residuals below this are zero but for rounding


def draw(library: GaitLibrary) -> Figure:
    """Maps of iterations and worst residual, and the worst residual of each constraint."""
    figure = new_figure(7.2)
    first, second, bars = figure.subplots(3, 1, height_ratios=(1, 1, 3.2))
    iterations = library.arrays["iterations"]
    draw_map(first, library, VelocityMap("IPOPT iterations", iterations, "iterations"))
    residual, unit = (
        np.maximum(library.arrays["max_violation"], _FLOOR),
        "SI unit of\nthe constraint",
    )
    draw_map(second, library, VelocityMap("worst residual", residual, unit, logarithmic=True))
    _residuals(bars, library)
    return figure


def caption(library: GaitLibrary) -> str:
    """Outcome in numbers; holes with what they violate."""
    arrays = library.arrays
    count = len(library) + len(library.holes)
    iterations = arrays["iterations"]
    outcomes = Counter(map(str, arrays["status"])).most_common()
    statuses = ", ".join(f"{status} {number}" for status, number in outcomes)
    lines = [
        f"{len(library)} of {count} gaits converged, in {iterations.min()} to {iterations.max()} "
        f"iterations (median {np.median(iterations):g}); the worst residual is "
        f"{arrays['max_violation'].max():.1e}. IPOPT's outcomes: {statuses}. Each gait is solved "
        "by itself from the same start. The bars are the worst residual of each constraint over "
        "all gaits, in its own unit. Solve times differ from run to run and are in "
        "`solve_times.md`."
    ]
    if library.holes:
        lines.append("")
    for hole in library.holes:
        worst = "; ".join(f"{name} {value:.1e}" for name, value in [*hole.residuals.items()][:5])
        lines.append(f"* hole at ({hole.vx:g}, {hole.vy:g}) m/s: {hole.status}; {worst}")
    return "\n".join(lines) + "\n"


def draw_times(library: GaitLibrary, times: np.ndarray) -> Figure:
    """Map of the times (G,) [s], and how many gaits took how long."""
    figure = new_figure(3.6)
    top, bottom = figure.subplots(2, 1, height_ratios=(1, 1.3))
    draw_map(top, library, VelocityMap("solve time", times, "s of processor"))
    bottom.hist(times[np.isfinite(times)], bins=30, color=DARK, rwidth=0.9)
    bottom.set(xlabel="processor time of IPOPT [s]", ylabel="gaits")
    return figure


def times_caption(times: np.ndarray) -> str:
    """The times in numbers."""
    known = times[np.isfinite(times)]
    return (
        f"Processor time of IPOPT from a cold start, without imports and building the problem: "
        f"median {np.median(known):.2f} s, greatest {known.max():.2f} s, {known.sum():.0f} s in "
        f"all for {len(known)} gaits. Measured when each gait was computed, with whatever else "
        "the machine was doing; grey cells: not known.\n"
    )


def _residuals(axes: Axes, library: GaitLibrary) -> None:
    worst = np.maximum(library.arrays["residuals"].max(axis=0), _FLOOR)
    order = np.argsort(worst, kind="stable")
    names = [library.constraints[i].replace("_", " ") for i in order]
    axes.barh(names, worst[order], color=DARK, height=0.6)
    axes.set_xscale("log")
    axes.set_xlim(_FLOOR, max(10 * float(worst.max()), 1e-6))
    axes.set_xlabel(f"worst residual over all gaits [SI unit of the constraint], {_FLOOR:g}: none")
    axes.tick_params(axis="y", labelsize=6.5, length=0)
    axes.grid(visible=False, axis="y")
