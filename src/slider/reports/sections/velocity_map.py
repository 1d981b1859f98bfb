"""A chart of quantities of gaits over the commanded velocity; the reader chooses which."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import plotly.graph_objects as go


def velocity_map(velocities: np.ndarray, quantities: Mapping[str, np.ndarray]) -> go.Figure:
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
