"""The stage ``report``: one self-contained page, from the reports and the sections below."""

import json
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from importlib.resources import files
from itertools import groupby
from pathlib import Path
from typing import Any

import pandas as pd

from slider.config.control import POLICY
from slider.core import tables
from slider.core.job import Inputs, Job, Section, Summary
from slider.core.quantities import speed_text
from slider.core.tables import Table
from slider.reports import html, provenance
from slider.reports.figures import walking
from slider.reports.figures.style import write_pictures
from slider.reports.sections import page_section
from slider.reports.table1 import TRADEOFF
from slider.reports.video import ABOUT, FILM
from slider.training.results import Training

PAGE = "index.html"
STATEMENTS = "statements.csv"
_TITLE = "SLIDER: extended hybrid zero dynamics and gait-guided learning"
_NONE = "This run has none."
_TRAININGS = {
    "standing": "Standing",
    "untuned": "Walking, before fine-tuning",
    "walking": "Walking",
}


@dataclass(frozen=True)
class Page:
    """What sections are written from; ``files`` collects their pictures and films by name."""

    section: Section
    inputs: Inputs
    out: Path
    job: Job
    files: dict[str, Path] = field(default_factory=dict)

    def films(self) -> list[dict[str, Any]]:
        """What each video shows, with its name among the files and a caption."""
        films = []
        for index, folder in enumerate(self.inputs.get("videos", ())):
            about = json.loads((folder / ABOUT).read_text(encoding="utf-8"))
            fate = f"walks at {about['mean_velocity']:z.2f} m/s"
            if about["fell_at"] is not None:
                fate = f"falls after {about['fell_at']:.1f} s"
            about |= {"name": f"film_{index}", "caption": f"{about['label']}: {fate}"}
            self.files[about["name"]] = folder / FILM
            films.append(about)
        return films


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write ``index.html`` with the configured sections, each from its declared inputs."""
    page, names, shown = Page(section, inputs, out, job), section["report"]["sections"], {}
    for name in names:
        about = page_section(name)
        if name in WRITERS:
            parts = [(tables.markdown(WRITERS[name](page)), page.files)]
        else:  # the section's heading replaces its first report's
            first, *others = (_document(inputs, place) for place in about.documents)
            parts = [(re.sub(r"\A# .*", "", first[0]), first[1]), *others]
        shown[name] = about.title, "".join(html.html(*part) for part in parts)
    text = html.page(_TITLE, shown)
    (out / PAGE).write_text(text, encoding="utf-8")
    return {"sections": names, "megabytes": round(len(text.encode()) / 1e6, 1)}


def _document(inputs: Inputs, place: str) -> tuple[str, dict[str, Path]]:
    """A report of an input; its pictures are beside it."""
    name, file = place.split("/")
    if name not in inputs:
        return _NONE, {}
    (folder,) = inputs[name]
    files = {f"{at}{path.name}": path for path in folder.iterdir() for at in ("", "figures/")}
    return (folder / file).read_text(encoding="utf-8"), files


def overview(page: Page) -> Iterator[str]:
    """A film of the walking robot, and the figure of error over cost of transport."""
    films = [about for about in page.films() if about["fell_at"] is None]
    films.sort(key=lambda about: (about["controller"] != POLICY, -about["speed"]))
    first = [f'![{about["caption"]}]({about["name"]} "autoplay")' for about in films[:1]]
    page.files[TRADEOFF] = page.inputs["table1"][0] / f"{TRADEOFF}.svg"
    yield "\n".join([*first, f"![Velocity error over cost of transport]({TRADEOFF})"])


def videos(page: Page) -> Iterator[str | Table]:
    """A row of films per speed, one film per controller; then those on terrain."""
    films = sorted(page.films(), key=lambda about: (about["terrain"], about["speed"]))
    yield "One robot per film, all from the same start at rest." if films else _NONE
    for (terrain, speed), mine in groupby(films, lambda film: (film["terrain"], film["speed"])):
        yield f"## {f'{terrain}, ' if terrain else ''}{speed_text(speed)} m/s"
        yield "\n".join(f"![{about['caption']}]({about['name']})" for about in mine)


def learning(page: Page) -> Iterator[str | Table]:
    """For each training its periodic checks and, where recorded, the terms of its reward."""
    yield (
        "Periodic checks on a few robots (score: lower is better), and the largest terms of the "
        "reward, weighted."
    )
    for name, title in _TRAININGS.items():
        if name in page.inputs:  # there may be no pre-training, no fine-tuning
            training = Training.load(page.inputs[name][0])
            picture = page.out / f"training_{name}.svg"
            write_pictures(picture, partial(walking.draw_training, training))
            page.files[picture.name] = picture
            yield f"## {title}"
            yield f"![{title}]({picture.name})"
            yield f"The policy of iteration {training.kept} was kept."


def paper_statements(page: Page) -> Iterator[str | Table]:
    """A table per part of the paper, a row per statement."""
    yield "What the paper says, whether it is here as printed, and where that is configured."
    heads = ["the paper says", "status", "here", "where"]
    for part, statements in read_statements().groupby("part", sort=False):
        yield Table(heads, statements.drop(columns="part").to_numpy(), str(part))


def read_statements() -> pd.DataFrame:
    """Each statement: part of the paper, what it says, status, what is here, and where."""
    with (files("slider.reports") / STATEMENTS).open(encoding="utf-8") as file:
        return pd.read_csv(file, keep_default_na=False, dtype=str)


def origins(page: Page) -> Iterator[str | Table]:
    """Commit, configuration, recipes, versions, seeds, machine, times."""
    jobs = [
        one
        for name, recorded in page.section["origins"].items()
        for one in zip(recorded, page.job.input_metadata[name], page.inputs[name], strict=True)
    ]
    return provenance.blocks(page.section["configuration"], jobs, page.job.metadata)


WRITERS: dict[str, Callable[[Page], Iterator[str | Table]]] = {
    "overview": overview,
    "videos": videos,
    "learning": learning,
    "statements": paper_statements,
    "provenance": origins,
}
"""Sections that no report of the pipeline has."""
