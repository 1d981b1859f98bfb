"""The gait library: maps over the commanded velocity, and the limit cycle of each gait."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go
import zarr
from plotly.subplots import make_subplots

from slider.reports.charts import Chart, chart
from slider.reports.controllers import colour
from slider.reports.sections.registry import Sources
from slider.reports.table import Text
from slider.robot.names import CHANNELS

MAP, CYCLE = "gait-map", "limit-cycle"
_FIRST_SHOWN = (0.6, 0.0)  # the cycle drawn before anything is hovered [m/s]


@dataclass(frozen=True)
class _Gaits:
    """What is drawn of G gaits with S samples each."""

    velocities: np.ndarray  # (G, 2) [m/s]
    quantities: dict[str, np.ndarray]  # title → (G,)
    cycles: dict[str, np.ndarray]  # title → (G, curves, S, 2), closed curves


def blocks(sources: Sources) -> Iterator[Text | Chart]:
    """A map whose colour can be chosen; hovering a gait draws its limit cycle beside it."""
    gaits = _read(sources.file("library", "library.zarr"))
    first = int(np.argmin(np.linalg.norm(gaits.velocities - _FIRST_SHOWN, axis=1)))
    yield Text(
        f"{len(gaits.velocities)} gaits. Move the pointer over a gait, or tap it, to see its limit "
        "cycle. The menu above the map chooses the colour."
    )
    titles = _titles(gaits)
    yield chart(
        MAP,
        _map_figure(gaits.velocities, gaits.quantities),
        "Gaits of the library at their commanded velocities.",
        height=360,
        linked=CYCLE,
        details=_details(gaits, titles),
        shown=titles[first],
    )
    yield chart(
        CYCLE,
        _cycle_figure(gaits, first),
        "Limit cycles of the gait under the pointer: positions against velocities over one walk "
        "of two steps; straight jumps are the impacts.",
        height=360,
    )


def _read(path: Path) -> _Gaits:
    group = zarr.open_group(path, mode="r")

    def array(name: str) -> np.ndarray:
        return np.asarray(group[name][...])  # type: ignore[index]

    step_time, cost, base = array("step_time"), array("cost"), array("base")
    torques, velocities = array("knee_torques"), array("velocities")
    quantities = {
        "step time [s]": step_time.mean(axis=1),
        "cost, log10": np.log10(cost),
        "peak joint torque [N m]": np.abs(torques).max(axis=(1, 2)),
        "base height [m]": base[:, :, 2].mean(axis=1),
        "worst violation, log10": np.log10(np.maximum(array("max_violation"), 1e-16)),
        "iterations": array("iterations").astype(float),
    }
    return _Gaits(velocities, quantities, _cycles(array("samples"), array("roll")))


def _cycles(samples: np.ndarray, roll: np.ndarray) -> dict[str, np.ndarray]:
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


def _map_figure(velocities: np.ndarray, quantities: Mapping[str, np.ndarray]) -> go.Figure:
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


def _cycle_figure(gaits: _Gaits, index: int) -> go.Figure:
    figure = make_subplots(1, len(gaits.cycles), subplot_titles=list(gaits.cycles))
    for column, portraits in enumerate(gaits.cycles.values(), start=1):
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


def _titles(gaits: _Gaits) -> list[str]:
    return [f"{x:.2f}, {y:+.2f} m/s" for x, y in gaits.velocities]


def _details(gaits: _Gaits, titles: list[str]) -> str:
    """For each gait its title, and x and y of each curve of the figure of cycles, as JSON."""
    curves = [
        [
            np.round(portrait, 4).T.tolist()
            for portraits in gaits.cycles.values()
            for portrait in portraits[index]
        ]
        for index in range(len(titles))
    ]
    return json.dumps({"titles": titles, "curves": curves}, separators=(",", ":"))
