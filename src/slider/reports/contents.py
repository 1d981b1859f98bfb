"""Blocks of the page's sections; each function is called as its section is in ``sections``."""

import csv
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from importlib.resources import files
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from slider.config.convert import from_dict
from slider.config.evaluation import EvaluationConfig, VideoConfig
from slider.core.job import Inputs, Job, Section
from slider.evaluation.results import Evaluation
from slider.library.reader import STORE, GaitLibrary
from slider.reports import gauge as gauge_report
from slider.reports import protocols, study
from slider.reports import provenance as origins_report
from slider.reports import table1 as table1_report
from slider.reports.figures import checks, maps, walking
from slider.reports.figures import gaits as gait_figures
from slider.reports.figures.style import write_pictures
from slider.reports.quantities import PAPER, QUANTITIES, speed_text
from slider.reports.rows import Row, by, evaluations, read
from slider.reports.table import Cell, Heading, Picture, Table, Text, Written
from slider.reports.video import ABOUT, FILM, POSTER
from slider.training.results import Training
from slider.verification.quantities import QUANTITIES as CHECKED
from slider.verification.summary import place

READINGS = "readings.csv"
_TRAININGS = {
    "standing": "Standing",
    "untuned": "Walking, before fine-tuning",
    "walking": "Walking",
}
_NO_RENDERER = (
    "No videos: this machine renders neither with EGL nor with OSMesa. Install one of them (on "
    "Debian `libegl1 libegl-mesa0` or `libosmesa6`) and build the page again."
)
_PROTOCOLS = {
    "robust": "Noise, delay, pushes, and robots and ground that differ from those of the training.",
    "sweep": "Every command from standing to the fastest.",
    "joystick": "Commands as from a joystick, changing on the way.",
    "heldout": "Speeds between those that checkpoints are chosen by, a minute of each, stops, "
    "sideways.",
}
_SHOWN_FAILURES = 20
_HOLDS = {None: "–", True: "yes", False: "NO"}


Blocks = Iterator[Written | dict[str, Any]]
"""Blocks; a dictionary is one of the page alone, see ``templates/page.html``."""


@dataclass(frozen=True)
class Sources:
    """What the stage ``report`` is given.

    The section has ``report``, the resolved ``configuration``, ``labels`` of the controllers, and
    ``origins``: input → for each of its jobs stage, label, recipe, source digest, versions. The
    ``job`` has what differs between runs, of the inputs and of the page.
    """

    section: Section
    inputs: Inputs
    out: Path
    job: Job

    @property
    def configuration(self) -> Mapping[str, Any]:
        """The resolved configuration, as plain values."""
        return self.section["configuration"]

    def evaluations(self, name: str) -> list[Evaluation]:
        """Evaluations among the inputs of a target."""
        return evaluations(self.inputs[f"{name}.evaluations"], self.section["labels"])

    def file(self, name: str, path: str) -> Path:
        """File of the one result of an input."""
        return self.inputs[name][0] / path

    def draw(self, name: str, draw: Callable[[], Figure]) -> Path:
        """Draw ``name``.svg beside the page."""
        write_pictures(self.out / name, draw)
        return self.out / f"{name}.svg"


def overview(sources: Sources) -> Blocks:
    """The robot walking, success and error over the speed, and one sentence."""
    robot = sources.configuration["robot"]["name"]
    rows = table1_report.table_rows(sources.evaluations("table1"), robot)
    films = [(about, film) for about, film in _films(sources) if about["fell_at"] is None]
    films.sort(key=lambda item: (item[0]["controller"] != rows[0]["controller"], -item[0]["speed"]))
    svg = sources.draw("overview", partial(walking.draw_overview, rows))
    caption = (
        "Success rate, and velocity MSE after the warm-up of the robots that survive. Dotted, if "
        "the paper has this robot: its numbers."
    )
    film = films[0][1] if films else None
    plot, sentence = Picture(svg, caption), finding(rows)
    yield {"kind": "overview", "film": film, "plot": plot, "sentence": sentence}


def finding(rows: Sequence[Row]) -> str:
    """Success and error of the first controller beside the paper's, in one sentence."""
    mine = [row for row in rows if row["controller"] == rows[0]["controller"]]
    top = max(row["speed"] for row in mine)
    paper = [r for r in rows if r["source"] == PAPER and r["speed"] == top]
    success, mse = QUANTITIES["success_rate"], QUANTITIES["mse_steady"]
    printed = ""
    if paper:
        rate = success.text(paper[0]["success_rate"])
        printed = f" ({paper[0]['label']}: {rate} % at {speed_text(top)} m/s)"
    return (
        f"Of the robots with {mine[0]['label']} at least "
        f"**{success.text(min(row['success_rate'] for row in mine))} %** survive at every "
        f"commanded speed up to {speed_text(top)} m/s{printed}; the velocity MSE after the "
        f"warm-up is at most **{mse.text(max(row['mse_steady'] for row in mine))} m²/s²**."
    )


def table1(sources: Sources) -> Blocks:
    """Ours, the baselines' and the paper's side by side, and how it walks."""
    library = sources.inputs.get("table1.library", ())
    return table1_report.blocks(sources.evaluations("table1"), library, sources.configuration)


def tracking(sources: Sources) -> Blocks:
    """Forward velocity over time, as in the paper's figure."""
    speeds = sources.section["report"]["tracking_speeds"]
    results = sources.evaluations("table1")
    shown = [result for result in results if result.speed in speeds]
    if shown:
        period = sources.configuration["env"]["control_period"]
        svg = sources.draw(protocols.TRACKING, partial(walking.draw_tracking, shown, period))
        yield Picture(svg, protocols.TRACKING_CAPTION)
    yield from protocols.undrawn(results, speeds)


def videos(sources: Sources) -> Blocks:
    """A row of films per speed, one film per controller; then those on terrain."""
    video = from_dict(VideoConfig, sources.section["report"]["video"])
    if video.renderer == "none":
        yield Text("No videos: `report.video.renderer` is `none`.", "note")
        return
    rows: dict[str, list[dict[str, Any]]] = {}
    films = sorted(_films(sources), key=lambda one: (one[0]["terrain"], one[0]["speed"]))
    for about, film in films:
        place = f"{about['terrain']}, " if about["terrain"] else ""
        rows.setdefault(f"{place}{speed_text(about['speed'])} m/s", []).append(film)
    if not rows:
        yield Text(_NO_RENDERER, "note")
        return
    seen = " and ".join(video.cameras)
    yield Text(f"One robot per film, all from the same start at rest, seen from the {seen}.")
    yield {"kind": "films", "rows": rows}


def _films(sources: Sources) -> Iterator[tuple[dict[str, Any], dict[str, Any]]]:
    """Facts of each video; and the film, the picture in its place on paper, how the robot did."""
    for folder in sources.inputs.get("videos", ()):
        about = json.loads((folder / ABOUT).read_text(encoding="utf-8"))
        fate = f"walks at {about['mean_velocity']:z.2f} m/s"
        if about["fell_at"] is not None:
            fate = f"falls after {about['fell_at']:.1f} s"
        caption = f"{about['label']}: {fate}"
        yield about, {"path": folder / FILM, "poster": folder / POSTER, "caption": caption}


def gaits(sources: Sources) -> Blocks:
    """Figures of the gait library."""
    library = GaitLibrary.load(sources.file("library", STORE))
    yield Text(f"{len(library)} gaits; `reports/figures/` has all figures of them.")
    for name, caption in (
        ("gait_tiles", gait_figures.TILES_CAPTION),
        ("velocity_maps", maps.MAPS_CAPTION),
        ("limit_cycles", gait_figures.CYCLES_CAPTION),
    ):
        yield Picture(sources.file("figures", f"{name}.svg"), caption)


def verification(sources: Sources) -> Blocks:
    """The verdict of the independent checks, the maps, and one row per quantity."""
    about = json.loads(sources.file("verification", "verification.json").read_text("utf-8"))
    failures = about["failures"]
    bounded = sum(quantity["bound"] is not None for quantity in about["quantities"].values())
    yield Text(
        f"{about['gaits']} gaits, checked by other means than those that solved them: pinocchio "
        "and MuJoCo for the dynamics, another integrator for the orbit, a dense sampling between "
        "the nodes."
    )
    if failures:
        yield Text(f"{len(failures)} values are beyond their bounds, of {bounded}:", "failed")
        more = len(failures) - _SHOWN_FAILURES
        rest = [f"and {more} more; `reports/verification.json` has all"] if more > 0 else []
        yield Text("\n".join(f"* {text}" for text in [*failures[:_SHOWN_FAILURES], *rest]))
    else:
        yield Text(f"All {bounded} bounds hold.", "best")
    svg = sources.file(checks.NAME, f"{checks.NAME}.svg")
    yield Picture(svg, checks.VERIFICATION_CAPTION)
    yield _bounds(about["quantities"])


def _bounds(quantities: Mapping[str, Mapping[str, Any]]) -> Table:
    """Worst value over all gaits, its bound and gait, and the median, per checked quantity."""
    heads = ["check", "quantity", "meaning", "unit", "worst", "bound", "holds"]
    body = []
    for name, result in quantities.items():
        quantity, bound = CHECKED[name], result["bound"]
        worst, median = (
            Cell("not finite") if value is None else Cell(f"{value:.3g}", value)
            for value in (result["worst"], result["median"])
        )
        sign = "≥" if quantity.at_least else "≤"
        texts = str(quantity.check), f"`{name}`", quantity.meaning, checks.unit(name)
        limit = Cell("–") if bound is None else Cell(f"{sign} {bound:g}", bound)
        holds = Cell(_HOLDS[result["passed"]], failed=result["passed"] is False)
        body.append([*map(Cell, texts), worst, limit, holds, Cell(place(result)), median])
    return Table([*heads, "at vx, vy [m/s]", "median"], body)


def learning(sources: Sources) -> Blocks:
    """For each training its periodic checks and, where recorded, the terms of its reward."""
    for name, title in _TRAININGS.items():
        if name not in sources.inputs:  # no pre-training, no fine-tuning
            continue
        training = Training.load(sources.inputs[name][0])
        yield Heading(title)
        svg = sources.draw(f"training_{name}", partial(walking.draw_training, training))
        yield Picture(
            svg,
            "Periodic checks on a few robots (score: lower is better), and the largest terms of "
            f"the reward, weighted. The policy of iteration {training.kept} was kept.",
        )


def ablation(sources: Sources) -> Blocks:
    """What each choice of the method is worth."""
    return study.blocks("ablation", sources.inputs["ablation"][0])


def gauge(sources: Sources) -> Blocks:
    """The highest level of each axis that a controller passes."""
    yield Text("Highest levels that the robots pass; `docs/how-to/gauge.md` defines them.")
    rows = read(sources.file("gauge", "gauge.csv"))
    yield from gauge_report.blocks(rows, sources.file("gauge", "gauge.svg"))


def readings(sources: Sources) -> Blocks:
    """A table per part of the paper, a row per statement, with its value in this run."""
    yield Text("What the paper says, whether it is here as printed, and where that is configured.")
    heads = ["the paper says", "status", "here", "where", "in this run"]
    for part, statements in by(read_statements(), "part").items():
        rows = [
            [*(Cell(text) for text in list(statement.values())[1:])]
            + [Cell(in_effect(sources.configuration, statement["where"]))]
            for statement in statements
        ]
        yield Table(heads, rows, part)


def read_statements() -> list[dict[str, str]]:
    """Each statement: part of the paper, what it says, status, what is here, and where."""
    text = (files("slider.reports") / READINGS).read_text(encoding="utf-8")
    return list(csv.DictReader(text.splitlines()))


def in_effect(configuration: Mapping[str, Any], where: str) -> str:
    """Value of the first place, if that is a dotted path to a single value."""
    node: Any = configuration
    for name in where.split(", ")[0].split("."):
        if not isinstance(node, Mapping) or name not in node:
            return ""
        node = node[name]
    return "" if isinstance(node, (Mapping, list)) else str(node)


def provenance(sources: Sources) -> Blocks:
    """Commit, configuration, recipes, versions, seeds, machine, times."""
    times = sources.job.input_volatile
    jobs = [
        job
        for name, origins in sources.section["origins"].items()
        for job in zip(origins, times[name], sources.inputs[name], strict=True)
    ]
    return origins_report.blocks(sources.configuration, jobs, sources.job.volatile)


def _protocol(name: str, sources: Sources) -> Blocks:
    """The figure of a protocol's report, and its tables."""
    protocol = from_dict(EvaluationConfig, sources.configuration["protocols"][name])
    seeds = f"Seeds {protocol.seed} to {protocol.seed + protocol.trials - 1}."
    yield Text(f"{_PROTOCOLS[name]} {seeds}")
    svg = sources.file(name, f"{name}.svg")
    yield from protocols.blocks(name, svg, sources.evaluations(name), protocol)


robust, sweep, joystick, heldout = (partial(_protocol, name) for name in _PROTOCOLS)
