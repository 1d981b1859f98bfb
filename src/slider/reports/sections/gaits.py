"""The gait library: maps over the commanded velocity, and the limit cycle of each gait."""

import json
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from slider.library.reader import STORE, GaitLibrary
from slider.reports.charts import Chart, chart
from slider.reports.controllers import colour
from slider.reports.figures.convergence import solver_maps
from slider.reports.figures.maps import library_maps
from slider.reports.sections.sources import Sources
from slider.reports.table import Text
from slider.robot.names import CHANNELS

MAP, CYCLE = "gait-map", "limit-cycle"
Cycles = Mapping[str, np.ndarray]  # title → (G, curves, S, 2), closed curves
_FIRST_SHOWN = (0.6, 0.0)  # the cycle drawn before anything is hovered [m/s]


def blocks(sources: Sources) -> Iterator[Text | Chart]:
    """A map whose colour can be chosen; hovering a gait draws its limit cycle beside it."""
    library = GaitLibrary.load(sources.file("library", STORE)).straight
    first = int(np.argmin(np.linalg.norm(library.velocities - _FIRST_SHOWN, axis=1)))
    yield Text(
        f"{len(library)} gaits. Move the pointer over a gait, or tap it, to see its limit cycle. "
        "The menu above the map chooses the colour."
    )
    titles = [f"{x:.2f}, {y:+.2f} m/s" for x, y in library.velocities]
    cycles = _cycles(library.arrays["samples"], library.arrays["roll"])
    yield chart(
        MAP,
        map_figure(library.velocities, _quantities(library)),
        "Gaits of the library at their commanded velocities.",
        height=360,
        linked=CYCLE,
        details=_details(cycles, titles),
        shown=titles[first],
    )
    yield chart(
        CYCLE,
        _cycle_figure(cycles, first),
        "Limit cycles of the gait under the pointer: positions against velocities over one walk "
        "of two steps; straight jumps are the impacts.",
        height=360,
    )


def _quantities(library: GaitLibrary) -> dict[str, np.ndarray]:
    """Title → numbers (G,), those of the figures' maps."""
    found = {}
    for item in (*library_maps(library), *solver_maps(library)):
        unit = "" if item.unit == item.name.split()[-1] else f" [{item.unit}]".replace("\n", " ")
        if item.logarithmic:
            found[f"{item.name}{unit}, log10"] = np.log10(item.values)
        else:
            found[f"{item.name}{unit}"] = np.asarray(item.values, dtype=float)
    return found


def _cycles(samples: np.ndarray, roll: np.ndarray) -> Cycles:
    """Phase portraits (G, curves, S, 2): the unactuated roll, then joints of both legs."""
    # The second step is stored reflected, which turns the sign of a roll.
    unreflected = roll[..., :2] * np.array([1.0, -1.0])[None, :, None, None]
    flat = unreflected.reshape(len(roll), 1, -1, 2)
    joints = {
        "hip pitch [rad], [rad/s]": ("left_hip_pitch", "right_hip_pitch"),
        "slide [m], [m/s]": ("left_slide", "right_slide"),
    }
    portraits = {"roll about the foot [rad], [rad/s]": flat}
    for title, names in joints.items():
        portraits[title] = np.stack([_portrait(samples, name) for name in names], axis=1)
    return {title: np.concatenate([x, x[:, :, :1]], axis=2) for title, x in portraits.items()}


def _portrait(samples: np.ndarray, joint: str) -> np.ndarray:
    channels = [CHANNELS.index(f"{joint}.{kind}") for kind in ("position", "velocity")]
    return samples[:, :, channels]


def map_figure(velocities: np.ndarray, quantities: Mapping[str, np.ndarray]) -> go.Figure:
    """One square per gait, coloured by the quantity that is chosen, at first the first one.

    Args:
        velocities: (G, 2) commanded vx, vy [m/s].
        quantities: title with unit → (G,); NaN where a gait has none.
    """
    values = {title: [_plain(v) for v in array] for title, array in quantities.items()}
    shown = next(iter(values.values()))
    marker: dict[str, Any] = {
        "color": shown,
        "colorscale": "Viridis",
        "size": 11,
        "symbol": "square",
        "colorbar": _colorbar(next(iter(values))),
    }
    figure = go.Figure(
        go.Scatter(
            x=velocities[:, 0],
            y=velocities[:, 1],
            mode="markers",
            customdata=np.arange(len(velocities)),
            text=_texts(shown),
            hovertemplate="vx %{x:.2f}, vy %{y:.2f} m/s<br>%{text}<extra></extra>",
            marker=marker,
        )
    )
    if len(values) > 1:
        figure.update_layout(updatemenus=[_menu(values)])
    figure.update_layout(hovermode="closest")
    figure.update_xaxes(title_text="vx [m/s]")
    figure.update_yaxes(title_text="vy [m/s]")
    return figure


def _menu(values: Mapping[str, list[float | None]]) -> dict[str, Any]:
    buttons = [
        {
            "label": title,
            "method": "restyle",
            "args": [
                {
                    "marker.color": [numbers],
                    "marker.colorbar": [_colorbar(title)],
                    "text": [_texts(numbers)],
                }
            ],
        }
        for title, numbers in values.items()
    ]
    return {"buttons": buttons, "x": 0, "xanchor": "left", "y": 1.2, "yanchor": "top"}


def _colorbar(title: str) -> dict[str, Any]:
    """A bar that says what it shows: on paper there is no menu."""
    return {"thickness": 12, "title": {"text": title, "side": "right", "font": {"size": 11}}}


def _plain(value: float) -> float | None:
    """Four digits; JSON has no NaN."""
    return float(f"{value:.4g}") if np.isfinite(value) else None


def _texts(values: list[float | None]) -> list[str]:
    return ["–" if value is None else f"{value:.4g}" for value in values]


def _cycle_figure(cycles: Cycles, index: int) -> go.Figure:
    figure = make_subplots(1, len(cycles), subplot_titles=list(cycles))
    for column, portraits in enumerate(cycles.values(), start=1):
        for curve, portrait in enumerate(portraits[index]):
            figure.add_scatter(
                x=np.round(portrait[:, 0], 4),
                y=np.round(portrait[:, 1], 4),
                mode="lines+markers",
                name=("left", "right")[curve],
                legendgroup=str(curve),
                showlegend=column == 2,
                marker={"size": 3, "color": colour(curve)},
                line={"color": colour(curve), "width": 1.8, "dash": ("solid", "dot")[curve]},
                row=1,
                col=column,
            )
    figure.update_layout(legend={"orientation": "h", "y": -0.12, "x": 0.5, "xanchor": "center"})
    figure.update_annotations(font_size=12)
    return figure


def _details(cycles: Cycles, titles: list[str]) -> str:
    """For each gait its title, and x and y of each curve of the figure of cycles, as JSON."""
    curves = [
        [
            np.round(portrait, 4).T.tolist()
            for portraits in cycles.values()
            for portrait in portraits[index]
        ]
        for index in range(len(titles))
    ]
    return json.dumps({"titles": titles, "curves": curves}, separators=(",", ":"))
