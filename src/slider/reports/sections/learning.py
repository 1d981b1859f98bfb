"""Learning curves of standing and walking: the periodic checks and the terms of the reward."""

from collections.abc import Iterator

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from slider.core.columns import Columns
from slider.reports.charts import Chart, chart
from slider.reports.controllers import colour
from slider.reports.sections.sources import Sources
from slider.reports.table import Heading, Text
from slider.training.results import Training

_CHECKS = {
    "success": "share of robots that survive",
    "speed_error": "speed error [m/s]",
    "flight": "flight share",
    "value": "score (lower is better)",
}
_PANELS = 4  # in a row
_LOG_TICKS = [m * 10.0**e for e in range(-6, 7) for m in (1, 3)]
_TRAININGS = {
    "standing": "Standing",
    "untuned": "Walking, before fine-tuning",
    "walking": "Walking",
}
_UNRECORDED = "This training recorded no curves of its reward terms; MLflow has them."


def blocks(sources: Sources) -> Iterator[Heading | Chart | Text]:
    """For each training its periodic evaluation and, where recorded, every curve by group."""
    for name, title in _TRAININGS.items():
        if name not in sources.inputs:  # no pre-training, no fine-tuning
            continue
        training = Training.load(sources.inputs[name][0])
        yield Heading(title)
        yield checks_chart(name, training)
        if training.curve:
            yield from _curve_charts(name, training.curve)
        else:
            yield Text(_UNRECORDED, "note")


def checks_chart(name: str, training: Training) -> Chart:
    """A panel per number of the periodic checks; gaps where a check did not find it."""
    table = training.checks
    names = [column for column in _CHECKS if not np.isnan(table[column]).all()]
    figure = make_subplots(1, len(names), subplot_titles=[_CHECKS[column] for column in names])
    for index, column in enumerate(names):
        figure.add_scatter(
            x=table["iteration"],
            y=table[column],
            mode="lines+markers",
            line={"color": colour(index), "width": 1.8},
            marker={"size": 5},
            name=_CHECKS[column],
            showlegend=False,
            row=1,
            col=index + 1,
        )
        figure.update_yaxes(rangemode="nonnegative", row=1, col=index + 1)
        if column == "value" and (table[column] > 0).all():
            ticks = {"tickvals": _LOG_TICKS, "ticktext": [f"{tick:g}" for tick in _LOG_TICKS]}
            figure.update_yaxes(type="log", **ticks, row=1, col=index + 1)
    figure.update_xaxes(title_text="iteration")
    figure.update_annotations(font_size=12)
    kept = f"the policy of iteration {training.kept} was kept"
    caption = f"Periodic evaluation on a few robots; {kept}."
    return chart(f"checks-{name}", figure, caption, 280)


def _curve_charts(name: str, table: Columns) -> list[Chart]:
    """Terms of the reward over each other, since they add up; other curves apart."""
    curves = [column for column in table if "/" in column]
    terms = [column for column in curves if "reward" in column.partition("/")[0].lower()]
    others = [column for column in curves if column not in terms]
    charts = []
    if terms:
        caption = "Terms of the reward during training, weighted."
        charts.append(chart(f"rewards-{name}", _overlaid(table, terms), caption, 380))
    if others:
        caption = "Recorded at every iteration of the training."
        height = 90 + 190 * _rows(others)
        charts.append(chart(f"curves-{name}", _panels(table, others), caption, height))
    return charts


def _overlaid(table: Columns, columns: list[str]) -> go.Figure:
    figure = go.Figure()
    for index, column in enumerate(columns):
        line = {"color": colour(index), "width": 1.5, "dash": _dash(index)}
        figure.add_scatter(
            x=table["iteration"], y=_short(table[column]), name=_term(column), line=line
        )
    figure.update_xaxes(title_text="iteration")
    return figure


def _panels(table: Columns, columns: list[str]) -> go.Figure:
    rows, titles = _rows(columns), [_title(column) for column in columns]
    figure = make_subplots(rows, _PANELS, subplot_titles=titles, vertical_spacing=0.3 / rows)
    for index, column in enumerate(columns):
        figure.add_scatter(
            x=table["iteration"],
            y=_short(table[column]),
            line={"color": colour(0), "width": 1.5},
            name=titles[index],
            showlegend=False,
            row=index // _PANELS + 1,
            col=index % _PANELS + 1,
        )
    figure.update_xaxes(nticks=5)
    figure.update_annotations(font_size=12)
    return figure


def _rows(columns: list[str]) -> int:
    return -(-len(columns) // _PANELS)


def _term(column: str) -> str:
    return column.partition("/")[2].replace("_", " ")


def _title(column: str) -> str:
    """Group and name, such as ``loss: entropy``, or the name alone where it says the group."""
    group, term = column.partition("/")[0].lower().replace("_", " "), _term(column)
    return term if group in ("train", "episode") else f"{group}: {term}"


def _short(values: np.ndarray) -> list[float]:
    """Five digits are more than a screen shows."""
    return [float(f"{value:.5g}") for value in values]


def _dash(index: int) -> str:
    """Line style of curve ``index``, so that more curves than colours stay apart."""
    return ("solid", "dash", "dot", "dashdot")[index // 7 % 4]
