"""The stage ``report``: one self-contained page about everything."""

import base64
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape

from slider.core.job import Inputs, Job, Section, Summary
from slider.reports import contents
from slider.reports.contents import Sources
from slider.reports.quantities import speed_text
from slider.reports.sections import SECTIONS
from slider.reports.table import inline

PAGE = "index.html"
_TITLE = "SLIDER: extended hybrid zero dynamics and gait-guided learning"


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write ``index.html`` with the configured sections, each from its declared inputs."""
    report = section["report"]
    sources = Sources(section, inputs, out, job)
    shown = {name: tuple(getattr(contents, name)(sources)) for name in report["sections"]}
    page = render(_TITLE, _facts(sources), shown)
    (out / PAGE).write_text(page, encoding="utf-8")
    return {"sections": report["sections"], "megabytes": round(len(page.encode()) / 1e6, 1)}


def render(title: str, facts: Mapping[str, str], blocks: Mapping[str, Sequence[Any]]) -> str:
    """The whole page as one HTML text that needs nothing else, and no script.

    ``blocks`` are those of each section, see ``templates/page.html``.
    """
    environment = Environment(
        loader=PackageLoader("slider.reports", "templates"),
        autoescape=select_autoescape(["html"]),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"inline": inline, "data": data_address}
    return environment.get_template("page.html").render(
        title=title,
        facts=facts,
        titles={name: SECTIONS[name].title for name in blocks},
        blocks=blocks,
        style=environment.get_template("page.css").render(),
    )


def data_address(path: Path, kind: str) -> str:
    """A file as a ``data:`` address of a media type; texts are shorter without base64."""
    if kind == "image/svg+xml":
        return f"data:{kind},{quote(path.read_text(encoding='utf-8'), safe=_SAFE)}"
    return f"data:{kind};base64,{base64.b64encode(path.read_bytes()).decode()}"


_SAFE = " /:;=,.-_()!$*+@?[]{}'|^`~"
"""Characters of an SVG that may stand in an address within double quotes."""


def _facts(sources: Sources) -> dict[str, str]:
    """Robot, controllers, commanded speeds, and amounts of evaluation and training."""
    configuration = sources.configuration
    evaluation = configuration["evaluation"]
    sizes = ("iterations", "robots", "steps_per_iteration")
    samples = sum(  # control steps of both trainings, or of one
        math.prod(train.get(name, 0) for name in sizes)
        for train in (configuration["train"]["walking"], configuration["finetuning"] or {})
    )
    labels = sources.section["labels"]
    return {
        "robot": configuration["robot"]["name"],
        "controllers": " · ".join(labels[name] for name in evaluation["controllers"]),
        "commanded speeds": ", ".join(map(speed_text, evaluation["speeds"])) + " m/s",
        "robots per speed": f"{evaluation['trials']} trials × {evaluation['robots']}",
        "training": f"{samples / 1e6:.1f} million control steps",
    }
