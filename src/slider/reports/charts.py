"""Interactive figures of the page, without colours of their own for text and ground."""

from dataclasses import dataclass
from typing import ClassVar

import plotly.graph_objects as go
import plotly.io


@dataclass(frozen=True)
class Chart:
    """An interactive figure.

    Attributes:
        name: unique on the page.
        spec: plotly's JSON.
        caption: below the figure.
        height: [pixel].
        linked: name of the chart that shows the details of what is hovered here.
        details: for each point, by its ``customdata``, arrays (x, y) for the linked chart's curves.
        shown: title of the details that are shown at first.
    """

    kind: ClassVar = "chart"
    name: str
    spec: str
    caption: str
    height: int
    linked: str = ""
    details: str = ""
    shown: str = ""


def chart(name: str, figure: go.Figure, caption: str, height: int = 380, **linked: str) -> Chart:
    """Figure in the colours of the page's theme; ``linked`` are further fields of a chart."""
    figure.update_layout(
        template="none",
        colorway=None,
        paper_bgcolor="rgba(0,0,0,0)",
        plot_bgcolor="rgba(0,0,0,0)",
        margin={"l": 60, "r": 20, "t": 40, "b": 50},
        hoverlabel={"align": "left"},
    )
    figure.update_layout(height=height, autosize=True)
    return Chart(name, _harmless(plotly.io.to_json(figure)), caption, height, **linked)


def _harmless(json: str | None) -> str:
    """JSON that cannot end the script element that it stands in."""
    return (json or "").replace("</", "<\\/")
