"""Gaits over the commanded velocities: quantities, smoothness, convergence and solve times."""

from collections import Counter
from collections.abc import Sequence

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from slider.library import measures
from slider.library.measures import smoothness
from slider.library.reader import GaitLibrary
from slider.reports.figures.style import COLOURS, DARK, EMPTY, MIDDLE, new_figure
from slider.robot.names import channels, velocity_text

MAPS_CAPTION = """\
One cell per gait; a red cross marks a velocity whose gait did not converge, and white is outside
the grid. Gaits that turn are left out. The cost is that of the optimisation (`gait.cost`). Torque
and voltage are the greatest of all motors over the walk, as shares of the motor's torque limit and
of its torque-speed line.
"""
_FLOOR = 1e-12  # residuals below this are zero but for rounding


def draw_map(
    axes: Axes,
    library: GaitLibrary,
    title: str,
    values: np.ndarray,
    unit: str,
    logarithmic: bool = False,
) -> None:
    """One coloured cell per gait, a cross at each hole, a colour bar with the unit.

    ``values`` (G,) are in the order of the library, NaN where a gait has none; ``logarithmic``
    colours them by powers of ten.

    Raises:
        ValueError: not one value per gait.
    """
    if values.shape != (len(library),):
        raise ValueError(f"{title}: expected {len(library)} values, found {values.shape}")
    places = np.array([*library.velocities[:, :2], *((h.vx, h.vy) for h in library.holes)])
    rectangles, limits = [], []
    for axis, value, place in zip(
        (library.mesh.vx, library.mesh.vy), library.velocities[:, :2].T, places.T, strict=True
    ):
        low, high = _borders(axis)
        index, margin = np.searchsorted(axis, value), float((high - low).max()) / 2
        rectangles.append((low[index], (high - low)[index]))
        limits.append((place.min() - margin, place.max() + margin))
    (left, width), (bottom, height) = rectangles
    cells = PatchCollection(
        [Rectangle((x, y), *size) for x, y, *size in zip(left, bottom, width, height, strict=True)],
        cmap=colormaps[COLOURS].with_extremes(bad=EMPTY),
        norm=_norm(values[np.isfinite(values)], logarithmic),
    )
    cells.set_array(np.ma.masked_invalid(values))
    cells.set(edgecolor="white", linewidth=0.4)
    axes.add_collection(cells)
    axes.set(xlabel="commanded forward velocity [m/s]", ylabel="leftward\n[m/s]")
    axes.set(xlim=limits[0], ylim=limits[1])
    axes.grid(visible=False)
    for hole in library.holes:
        axes.plot(hole.vx, hole.vy, "x", color=MIDDLE, markersize=4, markeredgewidth=1.2)
    bar = axes.figure.colorbar(cells, ax=axes, pad=0.01, aspect=8)
    bar.set_label(unit)
    bar.outline.set_visible(False)  # type: ignore[reportCallIssue]
    axes.set_title(title, loc="left")


def draw_velocity_maps(library: GaitLibrary) -> Figure:
    """What the library alone can give: cost, times, base height and use of the drives."""
    torque, voltage = (100 * shares.max(axis=1) for shares in measures.motor_shares(library))
    slides = library.robot.geometry.knee is None
    return draw_maps(
        library,
        [
            ("cost", library.arrays["cost"], library.cost_unit),
            ("step time", library.arrays["step_time"].mean(axis=1), "s"),
            ("base height", library.arrays["base"][:, :, 2].mean(axis=1), "m"),
            ("motor torque", torque, "% of limit"),
            ("motor voltage", voltage, "% of the bus"),
            ("slide speed", measures.slide_speed(library), "m/s" if slides else "rad/s"),
        ],
    )


def draw_maps(library: GaitLibrary, maps: Sequence[tuple[str, np.ndarray, str]]) -> Figure:
    """Maps (title, values, unit) one below the other, with a common velocity axis."""
    figure = new_figure(1.25 * len(maps) + 0.3)
    panels = figure.subplots(len(maps), 1, sharex=True, squeeze=False)[:, 0]
    for axes, item in zip(panels, maps, strict=True):
        draw_map(axes, library, *item)
        axes.label_outer()
    return figure


def _borders(axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Half way to the neighbours, below and above each value."""
    half = np.diff(axis) / 2 if len(axis) > 1 else np.array([0.025])
    below, above = np.concatenate([half[:1], half]), np.concatenate([half, half[-1:]])
    return axis - below[: len(axis)], axis + above[: len(axis)]


def _norm(values: np.ndarray, logarithmic: bool) -> Normalize:
    if not len(values):
        return Normalize(0.0, 1.0)
    if not logarithmic:
        low, high = float(values.min()), float(values.max())
        margin = 0.01 * abs(low) if np.isclose(low, high) else 0.0  # else only rounding shows
        return Normalize(low - margin, high + margin)
    positive = values[values > 0]
    low = float(positive.min()) if len(positive) else 1e-12
    return LogNorm(low, max(float(values.max()), 10 * low))


def draw_smoothness(library: GaitLibrary) -> Figure:
    """Map of each gait's greatest jump, and the greatest jump of each channel."""
    measured = smoothness(library.velocities, library.arrays["samples"])
    jumps = 100 * measured.per_gait(len(library))
    figure = new_figure(4.9)
    top, bottom = figure.subplots(2, 1, height_ratios=(1, 2.4))
    draw_map(top, library, "greatest jump to a neighbouring gait", jumps, "% of range")
    names = channels(library.robot.geometry)
    active = [i for i, name in enumerate(names) if "upper_foot" not in name]
    by_channel = 100 * measured.jumps.max(axis=0, initial=0.0)[active]
    order = np.argsort(by_channel)
    _bars(bottom, [names[active[i]] for i in order], by_channel[order])
    bottom.set(xlabel="greatest jump of the channel between neighbouring gaits [% of its range]")
    return figure


def _bars(axes: Axes, names: Sequence[str], values: np.ndarray) -> None:
    axes.barh(names, values, color=DARK, height=0.6)
    axes.tick_params(axis="y", labelsize=6.5, length=0)
    axes.grid(visible=False, axis="y")


def smoothness_caption(library: GaitLibrary) -> str:
    """The scale of a jump, and where the greatest one is."""
    measured = smoothness(library.velocities, library.arrays["samples"])
    text = (
        "Difference between gaits that follow one another in vx or in vy, at the same sample, as a "
        "share of the channel's range over the whole library (all gaits and samples). "
    )
    if not len(measured.pairs):
        return text + "This library has no neighbouring gaits.\n"
    first, second, channel = measured.worst
    name = channels(library.robot.geometry)[channel]
    places = [velocity_text(command) for command in library.velocities[[first, second]]]
    return text + (
        f"The greatest is {100 * measured.largest:.1f} % of {name}, between "
        f"{places[0]} and {places[1]}.\n"
    )


def draw_convergence(library: GaitLibrary) -> Figure:
    """Maps of iterations and worst residual, and the worst residual of each constraint."""
    figure = new_figure(7.2)
    first, second, bars = figure.subplots(3, 1, height_ratios=(1, 1, 3.2))
    arrays, floor = library.arrays, f"{_FLOOR:g}: none"
    draw_map(first, library, "IPOPT iterations", arrays["iterations"], "iterations")
    residual, unit = np.maximum(arrays["max_violation"], _FLOOR), "SI unit of\nthe constraint"
    draw_map(second, library, "worst residual", residual, unit, logarithmic=True)
    worst = np.maximum(arrays["residuals"].max(axis=0), _FLOOR)
    order = np.argsort(worst, kind="stable")
    _bars(bars, [library.constraints[i].replace("_", " ") for i in order], worst[order])
    bars.set(xscale="log", xlim=(_FLOOR, max(10 * float(worst.max()), 1e-6)))
    bars.set(xlabel=f"worst residual over all gaits [SI unit of the constraint], {floor}")
    return figure


def convergence_caption(library: GaitLibrary) -> str:
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
        worst = "; ".join([hole.status, *hole.violated[:5]])
        lines.append(f"* hole at ({hole.vx:g}, {hole.vy:g}) m/s: {worst}")
    return "\n".join(lines) + "\n"


def draw_times(library: GaitLibrary, times: np.ndarray) -> Figure:
    """Map of the times (G,) [s], and how many gaits took how long."""
    figure = new_figure(3.6)
    top, bottom = figure.subplots(2, 1, height_ratios=(1, 1.3))
    draw_map(top, library, "solve time", times, "s of processor")
    bottom.hist(times[np.isfinite(times)], bins=30, color=DARK, rwidth=0.9)
    bottom.set(xlabel="processor time of IPOPT [s]", ylabel="gaits")
    return figure


def times_caption(times: np.ndarray) -> str:
    """The times in numbers."""
    finite = times[np.isfinite(times)]
    return (
        f"Processor time of IPOPT from a cold start, without imports and building the problem: "
        f"median {np.median(finite):.2f} s, greatest {finite.max():.2f} s, {finite.sum():.0f} s in "
        f"all for {len(finite)} gaits. Measured when each gait was computed, with whatever else "
        "the machine was doing; grey cells: not finite.\n"
    )
