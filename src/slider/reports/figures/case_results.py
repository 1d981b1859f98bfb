"""Survival, standing and velocity errors of the cases of a profile, one colour per controller."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from slider.reports.controllers import colour, label
from slider.reports.figures.style import new_figure

_ROW, _REST = 0.19, 1.0  # height of a case and of the rest [inch]
_ERRORS = {  # column → marker, filled, name
    "vx_error": ("o", True, "error of mean vx"),
    "vy_error": ("o", False, "error of mean vy"),
    "fastest": ("D", True, "fastest robot after a stop"),
}
Row = Mapping[str, str | float]


def draw(rows: Sequence[Row]) -> Figure:
    """Cases down; shares of robots on the left, velocities [m/s] on the right."""
    cases = list(dict.fromkeys(str(row["case"]) for row in rows))
    controllers = list(dict.fromkeys(str(row["controller"]) for row in rows))
    height = _REST + _ROW * len(cases)
    figure = new_figure(height)
    figure.set_layout_engine(None)  # which cuts the names of the cases off
    figure.subplots_adjust(0.19, 0.5 * _REST / height, 0.98, 1 - 0.35 * _REST / height, 0.06)
    shares, errors = figure.subplots(1, 2, sharey=True)
    for index, controller in enumerate(controllers):
        mine = [row for row in rows if row["controller"] == controller]
        offset = 0.5 * ((index + 0.5) / len(controllers) - 0.5)
        places = np.array([cases.index(str(row["case"])) for row in mine]) + offset
        _shares(shares, mine, places, colour(index), (label(controller), "standing"))
        _errors(errors, mine, places, colour(index), named=index == 0)
    shares.set(xlabel="share of robots", xlim=(-0.04, 1.04), ylim=(len(cases) - 0.5, -0.5))
    shares.set_yticks(range(len(cases)), cases)
    errors.set(xlabel="velocity [m/s]")
    errors.set_xlim(left=0.0)
    named = [pair for axes in (shares, errors) for pair in _named(axes)]
    figure.legend(*zip(*named, strict=True), loc="upper center", ncols=5)
    return figure


def _named(axes: Axes) -> list[tuple[Artist, str]]:
    handles, names = axes.get_legend_handles_labels()
    return list(zip(handles, names, strict=True))


def _shares(
    axes: Axes, rows: Sequence[Row], places: np.ndarray, tint: str, names: tuple[str, str]
) -> None:
    """Dots for survival, rings below them for standing, with their intervals."""
    looks = (("success", tint, 0.0), ("standing", "white", 0.2))
    for (prefix, face, shift), name in zip(looks, names, strict=True):
        rate, low, high = (_column(rows, f"{prefix}_{end}") for end in ("rate", "low", "high"))
        bars = np.abs(np.stack([rate - low, high - rate]))
        look = {"color": tint, "markerfacecolor": face, "markersize": 4, "elinewidth": 0.8}
        axes.errorbar(rate, places + shift, xerr=bars, fmt="o", label=name, **look)


def _errors(axes: Axes, rows: Sequence[Row], places: np.ndarray, tint: str, named: bool) -> None:
    for column, (marker, filled, name) in _ERRORS.items():
        face = tint if filled else "white"
        look = {"color": tint, "markerfacecolor": face, "markersize": 4, "linestyle": "none"}
        values = _column(rows, column)
        axes.plot(values, places, marker=marker, label=name if named else None, **look)


def _column(rows: Sequence[Row], name: str) -> np.ndarray:
    """Values of a column, NaN where it is empty."""
    return np.array([float(row[name]) if row[name] != "" else np.nan for row in rows])
