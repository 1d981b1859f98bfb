"""How gaits depend on their mesh, and what random starts find."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from slider.reports.controllers import colour, speed
from slider.reports.figures.style import MIDDLE, new_figure
from slider.reports.rows import Row, by, distinct

_MARKERS = "os^vD*P"
_FLOOR = 1e-9  # costs closer than this are the same
_MESH = {  # column → title
    "torque_cost_difference": "∫ cost [-]",
    "joints_difference": "joints [rad]",
    "roll_end_difference": "roll at the end [rad]",
    "between_foot_line_moment": "roll equation [N m]",
}


def draw(meshes: Sequence[Row], starts: Sequence[Row], same: float) -> Figure:
    """Above, differences from the finest mesh over the nodes; below, starts over cost and effort.

    ``same``: up to which relative difference of cost two solutions count as one optimum.
    """
    figure = new_figure(4.8)
    above, below = figure.subfigures(2, 1, squeeze=False, height_ratios=(1, 1.1))[:, 0]
    panels = above.subplots(1, len(_MESH))
    for axes, (name, title) in zip(panels, _MESH.items(), strict=True):
        _draw_mesh(axes, meshes, name)
        axes.set_title(title)
    panels[0].set_ylabel("difference from the finest mesh")
    panels[-1].set_ylabel("residual between nodes")
    cost, effort = below.subplots(1, 2, sharey=True)
    _draw_starts(cost, starts, "cost_excess")
    _draw_starts(effort, starts, "iterations")
    cost.axvline(same, color=MIDDLE, linestyle="--", linewidth=0.8, label="the same optimum")
    cost.set(xlabel="cost above the best found [-]", ylabel="random starts [%]", ylim=(0, 104))
    cost.set_xscale("log")
    effort.set_xlabel("iterations")
    handles, labels = cost.get_legend_handles_labels()
    below.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    return figure


def _draw_mesh(axes: Axes, rows: Sequence[Row], name: str) -> None:
    """Without the finest mesh's differences from itself."""
    nodes = distinct(rows, "nodes")
    shown = nodes[:-1] if name.endswith("_difference") else nodes
    for index, mine in enumerate(by(rows, "command").values()):
        found = {row["nodes"]: max(abs(row[name]), _FLOOR) for row in mine}
        known = [(n, found[n]) for n in shown if not np.isnan(found[n])]
        _draw(axes, known, index)
        if known:
            axes.set_yscale("log")
            axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            axes.yaxis.set_major_formatter("{x:g}")
            axes.yaxis.set_minor_locator(NullLocator())
    axes.set(xscale="log", xlabel="nodes per step", xlim=(0.85 * nodes[0], 1.18 * nodes[-1]))
    axes.set_xticks(nodes, [f"{n:g}" for n in nodes])
    axes.xaxis.set_minor_locator(NullLocator())


def _draw_starts(axes: Axes, rows: Sequence[Row], name: str) -> None:
    """Which share of all random starts converge with no more than a value."""
    for index, (command, (_, *drawn)) in enumerate(by(rows, "command").items()):
        values = sorted(max(row[name], _FLOOR) for row in drawn if row["converged"])
        points = [(value, 100 * (i + 1) / len(drawn)) for i, value in enumerate(values)]
        _draw(axes, points, index, f"{speed(command)} m/s")


def _draw(axes: Axes, points: Sequence[tuple[float, float]], index: int, label: str = "") -> None:
    """Points of curve number ``index``."""
    x, y = np.array(points).reshape(-1, 2).T
    look = {"marker": _MARKERS[index % 7], "markersize": 3, "color": colour(index)}
    axes.plot(x, y, label=label, **look)
