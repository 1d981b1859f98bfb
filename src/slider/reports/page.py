"""The stage ``report``: one self-contained page about everything."""

import base64
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape
from markupsafe import Markup, escape
from plotly.offline import get_plotlyjs

from slider.config.convert import from_dict
from slider.config.report import ReportConfig
from slider.core.job import Inputs, Job, Section, Summary
from slider.reports.controllers import speed
from slider.reports.sections.registry import SECTIONS
from slider.reports.sections.sources import Sources

PAGE = "index.html"
_TITLE = "SLIDER: extended hybrid zero dynamics and gait-guided learning"


@dataclass(frozen=True)
class Content:
    """A section of the page: its title and its blocks, see ``templates/blocks.html``."""

    title: str
    blocks: Sequence[Any]


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write ``index.html`` with the configured sections, each from its declared inputs."""
    report = from_dict(ReportConfig, section["report"])
    sources = Sources(
        report=report,
        configuration=section["configuration"],
        labels=section["labels"],
        origins=section["origins"],
        inputs=inputs,
        times=job.input_volatile,
        page=job.volatile,
    )
    contents = {name: content(name, sources) for name in report.sections}
    page = render(_TITLE, _facts(sources), contents)
    (out / PAGE).write_text(page, encoding="utf-8")
    job.tracker.log_file(out / PAGE)
    return {"sections": report.sections, "megabytes": round(len(page.encode()) / 1e6, 1)}


def content(name: str, sources: Sources) -> Content:
    """What a section shows."""
    return Content(SECTIONS[name].title, tuple(SECTIONS[name].blocks(sources)))


def render(title: str, facts: Mapping[str, str], sections: Mapping[str, Content]) -> str:
    """The whole page as one HTML text that needs nothing else."""
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
        sections=sections,
        plotly=get_plotlyjs(),
        style=environment.get_template("page.css").render(),
        script=environment.get_template("page.js").render(),
    )


def inline(text: str) -> Markup:
    """Markdown within a paragraph: ``code`` and **bold**."""
    html = re.sub(r"`([^`]*)`", r"<code>\1</code>", str(escape(text)))
    return Markup(re.sub(r"\*\*([^*]+)\*\*", r"<strong>\1</strong>", html))


def data_address(path: Path, kind: str) -> str:
    """A file as a ``data:`` address of a media type."""
    return f"data:{kind};base64,{base64.b64encode(path.read_bytes()).decode()}"


def _facts(sources: Sources) -> dict[str, str]:
    """What a reader wants to know before anything else."""
    configuration = sources.configuration
    evaluation = configuration["evaluation"]
    trainings = (configuration["train"]["walking"], configuration["finetuning"] or {})
    samples = sum(map(_samples, trainings))
    return {
        "controllers": " · ".join(sources.labels[name] for name in evaluation["controllers"]),
        "commands": ", ".join(map(speed, evaluation["commands"])) + " m/s",
        "robots per command": f"{evaluation['trials']} trials × {evaluation['robots']}",
        "training": f"{samples / 1e6:.1f} million control steps",
    }


def _samples(train: Mapping[str, Any]) -> int:
    """Control steps of a training, or of none."""
    return math.prod(train.get(n, 0) for n in ("iterations", "robots", "steps_per_iteration"))
