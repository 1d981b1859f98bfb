"""Building blocks of the page, and the page itself."""

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import plotly.graph_objects as go
import plotly.io
from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape
from plotly.offline import get_plotlyjs


@dataclass(frozen=True)
class Cell:
    """A cell of a table: what is shown and what it is sorted by."""

    text: str
    key: float | str = ""
    best: bool = False
    failed: bool = False


@dataclass(frozen=True)
class Table:
    """A table, by default one that sorts by a click on a heading; numbers stand right."""

    columns: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    caption: str = ""
    sortable: bool = True

    @property
    def headings(self) -> list[tuple[str, bool]]:
        """Each column's heading, and whether numbers stand below it."""
        return [
            (column, any(isinstance(row[index].key, (int, float)) for row in self.rows))
            for index, column in enumerate(self.columns)
        ]


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
    """

    name: str
    spec: str
    caption: str
    height: int
    linked: str = ""
    details: str = ""


@dataclass(frozen=True)
class Picture:
    """A drawing of a stage, on a light card whatever the theme.

    Attributes:
        address: ``data:`` address.
        text: what it shows, for those who cannot see it.
        caption: below the picture.
    """

    address: str
    text: str
    caption: str


@dataclass(frozen=True)
class Section:
    """A section of the page: a template and what it shows."""

    title: str
    template: str
    values: Mapping[str, Any] = field(default_factory=dict)


def chart(
    name: str,
    figure: go.Figure,
    caption: str,
    height: int = 380,
    linked: str = "",
    details: str = "",
) -> Chart:
    """Figure without colours of its own for text and ground: the page's theme sets them."""
    figure.update_layout(
        template="none",
        colorway=None,
        paper_bgcolor="rgba(0,0,0,0)",
        plot_bgcolor="rgba(0,0,0,0)",
        margin={"l": 60, "r": 20, "t": 40, "b": 50},
        hoverlabel={"align": "left"},
    )
    figure.update_layout(height=height, autosize=True)
    return Chart(name, _harmless(plotly.io.to_json(figure)), caption, height, linked, details)


def picture(path: Path, text: str, caption: str) -> Picture:
    """The SVG file of a stage; an image of its own, so that names in several do not meet."""
    return Picture(data_address(path, "image/svg+xml"), text, caption)


def data_address(path: Path, kind: str) -> str:
    """A file as a ``data:`` address of a media type."""
    return f"data:{kind};base64,{base64.b64encode(path.read_bytes()).decode()}"


def _harmless(json: str | None) -> str:
    """JSON that cannot end the script element that it stands in."""
    return (json or "").replace("</", "<\\/")


def render_page(title: str, facts: Mapping[str, str], sections: Mapping[str, Section]) -> str:
    """The whole page as one HTML text that needs nothing else."""
    environment = Environment(
        loader=PackageLoader("slider.reports.sections", "templates"),
        autoescape=select_autoescape(["html"]),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    bodies = {
        name: environment.get_template(section.template).render(section.values)
        for name, section in sections.items()
    }
    return environment.get_template("page.html").render(
        title=title,
        facts=facts,
        sections=sections,
        bodies=bodies,
        plotly=get_plotlyjs(),
        style=environment.get_template("page.css").render(),
        script=environment.get_template("page.js").render(),
    )
