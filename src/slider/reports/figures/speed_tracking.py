"""Mean speed, survival and error over the commanded speed, one curve per controller."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from slider.reports.controllers import colour, label
from slider.reports.figures.style import DARK, new_figure

_LEAST_ERROR = 1e-4  # shown [m²/s²]: a robot that stands has nearly none
_DASHES = ("-", "--", "-.", ":")
_MARGIN = 0.15  # [inch]; the layout does not see the labels of the logarithmic axis


def draw(rows: Sequence[Mapping[str, str | float]]) -> Figure:
    """Three panels over a common axis; ``rows`` are those of the protocol's table."""
    figure = new_figure(6.2)
    speeds, rates, errors = figure.subplots(3, 1, sharex=True, height_ratios=(1.9, 1.0, 1.0))
    commands = _column(rows, "command_velocity")
    ends = [commands.min(), commands.max()]
    speeds.plot(ends, ends, color=DARK, linewidth=0.8, linestyle=(0, (1, 2)), label="command")
    for index, controller in enumerate(dict.fromkeys(row["controller"] for row in rows)):
        mine = [row for row in rows if row["controller"] == controller]
        mine.sort(key=lambda row: float(row["command_velocity"]))
        _curves((speeds, rates, errors), mine, index, label(str(controller)))
    speeds.set(ylabel="mean speed [m/s]")
    speeds.legend(loc="upper left")
    rates.set(ylabel="share of robots", ylim=(-0.04, 1.04))
    errors.set(ylabel="MSE [m²/s²]", yscale="log", xlabel="commanded speed [m/s]")
    figure.align_ylabels()
    figure.set_layout_engine("constrained", w_pad=_MARGIN)
    errors.set_ylim(bottom=_LEAST_ERROR)
    errors.yaxis.set_major_formatter("{x:g}")
    return figure


def _curves(
    panels: tuple[Axes, Axes, Axes],
    rows: Sequence[Mapping[str, str | float]],
    index: int,
    name: str,
) -> None:
    speeds, rates, errors = panels
    command, tint = _column(rows, "command_velocity"), colour(index)
    dashes = _DASHES[index % len(_DASHES)]
    mean, spread = _column(rows, "mean_velocity"), _column(rows, "mean_velocity_spread")
    speeds.fill_between(command, mean - spread, mean + spread, color=tint, alpha=0.2, linewidth=0)
    speeds.plot(command, mean, color=tint, linestyle=dashes, label=name)
    rates.plot(command, _column(rows, "success_rate"), color=tint, linestyle=dashes)
    rates.plot(command, _column(rows, "tracking_rate"), ".", color=tint, markersize=4)
    error = _column(rows, "mse_steady")
    errors.plot(command, np.where(np.isfinite(error), error, np.nan), color=tint, linestyle=dashes)


def _column(rows: Sequence[Mapping[str, str | float]], name: str) -> np.ndarray:
    """Values of a column, NaN where it is empty."""
    return np.array([float(row[name]) if row[name] != "" else np.nan for row in rows])
