"""How the optimisation ended over the grid, and how long it took, which no stage draws."""

from collections import Counter

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from slider.library.reader import GaitLibrary
from slider.reports.figures.maps import VelocityMap, draw_map, frame
from slider.reports.figures.style import DARK, new_figure

_MARKERS = "os^vD*P"
_FLOOR = 1e-12  # residuals below this are zero but for rounding


def draw(library: GaitLibrary) -> Figure:
    """Three maps, and the worst residual of each constraint over all gaits."""
    figure = new_figure(8.6)
    panels = figure.subplots(4, 1, height_ratios=(1, 1, 1, 3.2))
    for axes, item in zip(panels[:2], solver_maps(library), strict=True):
        draw_map(axes, library, item)
    _outcomes(panels[2], library)
    _residuals(panels[3], library)
    return figure


def solver_maps(library: GaitLibrary) -> list[VelocityMap]:
    """Iterations and worst residual of each gait."""
    residual = np.maximum(library.arrays["max_violation"], _FLOOR)
    unit = "SI unit of\nthe constraint"
    return [
        VelocityMap("IPOPT iterations", library.arrays["iterations"], "iterations"),
        VelocityMap("worst residual", residual, unit, logarithmic=True),
    ]


def caption(library: GaitLibrary) -> str:
    """Outcome in numbers; holes with what they violate."""
    arrays = library.arrays
    count = len(library) + len(library.holes)
    iterations = arrays["iterations"]
    lines = [
        f"{len(library)} of {count} gaits converged, in {iterations.min()} to {iterations.max()} "
        f"iterations (median {np.median(iterations):g}); the worst residual is "
        f"{arrays['max_violation'].max():.1e}. Each gait is solved by itself from the same start. "
        "The bars are the worst residual of each constraint over all gaits, in its own unit. "
        "Solve times differ from run to run and are in `solve_times.md`."
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


def _outcomes(axes: Axes, library: GaitLibrary) -> None:
    """A marker per return status; the commonest first."""
    found = [(*velocity, str(status)) for velocity, status in _converged(library)]
    found += [(hole.vx, hole.vy, hole.status) for hole in library.holes]
    counts = Counter(status for _, _, status in found)
    for marker, (status, count) in zip(_MARKERS, counts.most_common(), strict=False):
        vx, vy = zip(*[(x, y) for x, y, name in found if name == status], strict=True)
        label = f"{status} ({count})"
        fill, size = ("full", 3) if marker == _MARKERS[0] else ("none", 4.5)
        line = axes.plot(vx, vy, marker, color=DARK, fillstyle=fill, markersize=size, label=label)
        line[0].set_linestyle("")
    frame(axes, library)
    axes.set_title("IPOPT's outcome", loc="left")
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=len(counts), borderpad=0)


def _converged(library: GaitLibrary):
    return zip(library.planar_velocities, library.arrays["status"], strict=True)


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
