"""Velocity tracking over time, as in the paper's figure."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from slider.evaluation.results import Evaluation
from slider.reports.charts import Chart, chart
from slider.reports.controllers import colour, line, speed
from slider.reports.sections.sources import Sources
from slider.reports.table import Written
from slider.reports.velocity_tracking import CAPTION, fell, notes


def blocks(sources: Sources) -> Iterator[Chart | Written]:
    """One panel per command, one curve per controller."""
    found = sources.evaluations("table1")
    evaluated = {one.command for one in found}
    asked = sources.report.tracking_commands
    shown = [command for command in asked if command in evaluated]
    if shown:
        yield _chart(found, shown, sources.configuration["env"]["control_period"])
    yield from notes(found, asked)


def _chart(found: list[Evaluation], commands: list[float], period: float) -> Chart:
    rows = (len(commands) + 1) // 2
    titles = [f"{speed(command)} m/s" for command in commands]
    figure = make_subplots(rows, 2, subplot_titles=titles, vertical_spacing=0.22 / rows)
    controllers = list(dict.fromkeys(one.controller for one in found))
    for panel, command in enumerate(commands):
        place: dict[str, Any] = {"row": panel // 2 + 1, "col": panel % 2 + 1}
        for one in (item for item in found if item.command == command):
            index = controllers.index(one.controller)
            _add_trace(figure, one, period, index, panel == 0, place)
        figure.add_hline(command, line={"dash": "dash", "width": 1.2, "color": "#888"}, **place)
        if panel >= len(commands) - 2:
            figure.update_xaxes(title_text="time [s]", **place)
        figure.update_yaxes(title_text="velocity [m/s]", rangemode="tozero", **place)
    figure.update_layout(legend={"orientation": "h", "y": 1.0 + 0.16 / rows, "yanchor": "bottom"})
    return chart("velocity", figure, CAPTION, 80 + 290 * rows)


def _add_trace(
    figure: go.Figure,
    one: Evaluation,
    period: float,
    index: int,
    first: bool,
    place: dict[str, Any],
) -> None:
    if fell(one):
        return
    mean, spread = np.round(one.velocity.astype(float).T, 4)
    time = np.round(period * np.arange(1, len(mean) + 1), 3)
    name = one.label
    around = np.concatenate([time, time[::-1]])
    band = np.concatenate([mean + spread, (mean - spread)[::-1]])
    figure.add_scatter(
        x=around,
        y=np.round(band, 4),
        fill="toself",
        fillcolor=colour(index),
        opacity=0.25,
        line={"width": 0},
        hoverinfo="skip",
        legendgroup=name,
        showlegend=False,
        **place,
    )
    figure.add_scatter(
        x=time,
        y=mean,
        name=name,
        line=line(index),
        legendgroup=name,
        showlegend=first,
        **place,
    )
