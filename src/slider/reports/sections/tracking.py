"""Velocity tracking over time, as in the paper's figure."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from slider.reports.controllers import colour, label, line, speed
from slider.reports.page import Section, chart
from slider.reports.sections.sources import Sources

_CAPTION = (
    "Forward velocity from rest: mean over surviving robots, the band is one standard deviation "
    "between robots, dashed the command."
)


@dataclass(frozen=True)
class _Trace:
    controller: str
    command: float
    velocity: np.ndarray  # (S, 2) mean and standard deviation [m/s]

    @property
    def fell(self) -> bool:
        """Nobody survived: there is nothing to draw."""
        return bool(np.isnan(self.velocity[:, 0]).all())


def section(sources: Sources) -> Section:
    """One panel per command, one curve per controller."""
    traces = [_read(folder) for folder in sources.inputs["table1.evaluations"]]
    evaluated = {trace.command for trace in traces}
    wanted = sources.report.tracking_commands
    shown = [command for command in wanted if command in evaluated]
    missing = [speed(command) for command in wanted if command not in evaluated]
    period = sources.configuration["env"]["control_period"]
    charts = [_chart(traces, shown, period)] if shown else []
    fallen = [
        f"{label(trace.controller)} at {speed(trace.command)} m/s"
        for trace in traces
        if trace.command in shown and trace.fell
    ]
    values = {"charts": charts, "missing": missing, "fallen": fallen}
    return Section("Velocity tracking", "tracking.html", values)


def _read(folder: Path) -> _Trace:
    about = json.loads((folder / "command.json").read_text())
    return _Trace(about["controller"], about["command"], np.load(folder / "velocity.npy"))


def _chart(traces: list[_Trace], commands: list[float], period: float):
    rows = (len(commands) + 1) // 2
    titles = [f"{speed(command)} m/s" for command in commands]
    figure = make_subplots(rows, 2, subplot_titles=titles, vertical_spacing=0.22 / rows)
    controllers = list(dict.fromkeys(trace.controller for trace in traces))
    for panel, command in enumerate(commands):
        place: dict[str, Any] = {"row": panel // 2 + 1, "col": panel % 2 + 1}
        for trace in (t for t in traces if t.command == command):
            index = controllers.index(trace.controller)
            _add_trace(figure, trace, period, index, panel == 0, place)
        figure.add_hline(command, line={"dash": "dash", "width": 1.2, "color": "#888"}, **place)
        if panel >= len(commands) - 2:
            figure.update_xaxes(title_text="time [s]", **place)
        figure.update_yaxes(title_text="velocity [m/s]", rangemode="tozero", **place)
    figure.update_layout(legend={"orientation": "h", "y": 1.0 + 0.16 / rows, "yanchor": "bottom"})
    return chart("velocity", figure, _CAPTION, 80 + 290 * rows)


def _add_trace(
    figure: go.Figure, trace: _Trace, period: float, index: int, first: bool, place: dict[str, Any]
) -> None:
    if trace.fell:
        return
    mean, spread = np.round(trace.velocity.astype(float).T, 4)
    time = np.round(period * np.arange(1, len(mean) + 1), 3)
    name = label(trace.controller)
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
