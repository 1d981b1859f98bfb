"""The tables of the documentation by the name of their block, each from one published report.

A new one is a function here.
"""

import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from slider.artefacts.store import Store
from slider.hzd.summary import QUANTITIES as HZD_QUANTITIES
from slider.reports.comparison import METRICS
from slider.reports.controllers import PAPER, speed
from slider.reports.protocols.cases import case_tables
from slider.reports.protocols.speeds import highest_table
from slider.reports.quantities import QUANTITIES
from slider.reports.results.origin import ancestry, facts, made
from slider.reports.rows import NAN, Row, by, distinct, read
from slider.reports.sections.provenance import in_order, stage_title
from slider.reports.sections.verification import bounds_table
from slider.reports.table import grid, markdown

_PRINTED = "MSE as the paper prints it [m²/s²]"
_QUALITY = (
    "alternation",
    "touchdown_rate",
    "reference_touchdown_rate",
    "asymmetry",
    "flight",
    "slip",
    "clearance",
    "leg_distance",
    "robots_touch",
    "robots_cross",
    "heading",
    "heading_worst",
    "velocity_variance",
    "reference_velocity_variance",
    "peak_effort",
    "peak_speed",
)
_COMPARED = ("policy", "hzd", "mpc_wbc_tuned")
_LEARNING = (
    *("velocity_variance", "reference_velocity_variance", "cost_of_transport", "slip"),
    *("alternation", "flight", "clearance", "robots_cross", "robots_touch"),
)
_STABILITY = (
    *("spectral_radius", "closed_spectral_radius", "invariance_orbit", "invariance_impact"),
    *("invariance_free", "invariance_anchored", "settle_angle", "hip_share", "decoupling"),
)
_WALK_EDGES = (1.2, 2.0)  # between the ranges of speeds [m/s]
_ROBUST = ("success_rate", "tracking_rate", "mse_steady")
_SUMMARY = ("policy", "hzd", "mpc_wbc_tuned", "guided_drl")
_SHORT = {"success_rate": "success [%]", "mse_steady": "MSE [m²/s²]", "mse": "MSE [m²/s²]"}


class Unmade(Exception):
    """A table cannot be made from what is there: says what is missing; the block stays as it is."""


@dataclass(frozen=True)
class ResultTable:
    """A table of the documentation.

    Attributes:
        report: file of ``reports/`` that it is made from.
        make: Markdown from that file; the store says more where the file is not enough.
        command: that makes the file.
    """

    report: str
    make: Callable[[Path, Store], str]
    command: str


TABLES: dict[str, ResultTable] = {}
_Make = Callable[[Path, Store], str]


def block(report: str, target: str = "", command: str = "") -> Callable[[_Make], _Make]:
    """Declare the block that is called as the function; Snakemake makes its file or ``target``."""

    def declare(make: _Make) -> _Make:
        usual = f"snakemake -j2 reports/{target or report}"
        TABLES[make.__name__] = ResultTable(report, make, command or usual)
        return make

    return declare


@block("table1.csv")
def table1(report: Path, store: Store) -> str:
    """Success with its interval, both errors and tracking; the paper's own rows below ours."""
    rows = read(report)
    ours = [row for row in rows if row["source"] != PAPER]
    paper = [row for row in rows if row["source"] == PAPER]
    lines = _group(rows, "success_rate")
    lines += _group(ours, "mse_steady") + _group(ours, "mse") + _group(paper, "mse", _PRINTED)
    return _across(ours, [*lines, *_group(ours, "tracking_rate")])


@block("table1.csv")
def summary(report: Path, store: Store) -> str:
    """A line per command: success and settled error of ours, the best baseline and the paper's."""
    groups = by(read(report), "controller")
    shown = [groups[name] for name in _SUMMARY if name in groups]
    columns = [
        (METRICS[name] if mine[0]["source"] == PAPER else name, mine)
        for name in ("success_rate", "mse_steady")
        for mine in shown
    ]
    heads = [f"{_SHORT[name]}, {mine[0]['label']}" for name, mine in columns]
    body = []
    for command in distinct(shown[0], "command_velocity"):
        cells = [by(mine, "command_velocity").get(command, [{}])[0] for _, mine in columns]
        texts = [
            QUANTITIES[name].text(row.get(name, NAN))
            for (name, _), row in zip(columns, cells, strict=True)
        ]
        body.append([speed(command), *texts])
    return grid(["command [m/s]", *heads], body).markdown


@block("robust.csv")
def robust(report: Path, store: Store) -> str:
    """Success with its interval, tracking and settled error of disturbed robots."""
    rows = read(report)
    return _across(rows, [line for name in _ROBUST for line in _group(rows, name)])


@block("gait_quality.csv")
def quality(report: Path, store: Store) -> str:
    """The policy's quantities, and the cost of transport of the tuned baseline beside its own."""
    groups = by(read(report), "controller")
    mine = groups["policy"]
    lines = [(QUANTITIES[name].heading, "", mine, name) for name in _QUALITY]
    cost = "cost_of_transport"
    for whose in (groups[name] for name in _SUMMARY[:2] if name in groups):
        lines.append((QUANTITIES[cost].heading, whose[0]["label"], whose, cost))
    return _across(mine, lines)


@block("heldout.csv")
def heldout(report: Path, store: Store) -> str:
    """Up to three tables per controller."""
    return markdown(case_tables(read(report)), "**{}**")


@block("sweep.csv")
def sweep(report: Path, store: Store) -> str:
    """Highest speed that each controller tracks, and lower ones that it does not."""
    return highest_table(read(report)).markdown


@block("seeds.md", "seeds.csv")
def seeds(report: Path, store: Store) -> str:
    """All of the report."""
    return _whole(report)


@block("ablation.md", "ablation.csv")
def ablation(report: Path, store: Store) -> str:
    """All of the report."""
    return _whole(report)


@block("paper_method.md", "paper_method.csv")
def paper_method(report: Path, store: Store) -> str:
    """All of the report."""
    return _whole(report)


@block("gait_quality.csv")
def learning(report: Path, store: Store) -> str:
    """The gaits alone, the policy and the tuned baseline side by side, how they walk."""
    rows = [row for row in read(report) if row["controller"] in _COMPARED]
    return _across(rows, [line for name in _LEARNING for line in _group(rows, name)])


@block("stability.csv")
def stability(report: Path, store: Store) -> str:
    """Least, median and greatest over the gaits of what says how stable they are."""
    rows = read(report)
    body = []
    for name in _STABILITY:
        values = np.array([row[name] for row in rows], dtype=float)
        known = values[np.isfinite(values)]
        numbers = [f"{f(known):.3g}" for f in (np.min, np.median, np.max)]
        body.append([f"`{name}`", HZD_QUANTITIES[name].unit, *numbers])
    return grid([f"{len(rows)} gaits", "unit", "least", "median", "greatest"], body).markdown


@block("gait_walks.csv")
def gait_walks(report: Path, store: Store) -> str:
    """How many gaits of each range of speeds make all steps, and those that make the fewest."""
    rows, body = read(report), []
    most = max(row["walked"] for row in rows)
    edges = [-np.inf, *_WALK_EDGES, np.inf]
    for low, high in pairwise(edges):
        own = [row for row in rows if low < row["vx"] <= high]
        if own:
            done = sum(row["walked"] >= most for row in own)
            least = min(row["walked"] for row in own)
            upper = max(row["vx"] for row in own)
            cells = [f"{min(row['vx'] for row in own):g} … {upper:g}", str(len(own)), str(done)]
            body.append([*cells, f"{least:g}"])
    heads = ["vx [m/s]", "gaits", f"walk {most:g} steps", "fewest steps"]
    return grid(heads, body).markdown


@block("gait_convergence.md", "gait_convergence.csv")
def gait_convergence(report: Path, store: Store) -> str:
    """All of the report."""
    return _whole(report)


@block("gait_starts.md", "gait_starts.csv")
def gait_starts(report: Path, store: Store) -> str:
    """All of the report."""
    return _whole(report)


@block("sensitivity.md", "sensitivity.csv")
def sensitivity(report: Path, store: Store) -> str:
    """All of the report."""
    return _whole(report)


@block("verification.json", "verification.csv")
def verification(report: Path, store: Store) -> str:
    """How many bounds hold, and worst value, gait, median and bound of each quantity."""
    about = json.loads(report.read_text(encoding="utf-8"))
    bounded = [found for found in about["quantities"].values() if found["bound"] is not None]
    held = sum(bool(found["passed"]) for found in bounded)
    intro = f"{about['gaits']} gaits; {held} of {len(bounded)} bounds hold for all of them."
    return f"{intro}\n\n{bounds_table(about['quantities']).markdown}"


@block("table1.csv")
def times(report: Path, store: Store) -> str:
    """Jobs, wall time and processor time of each stage on the way to Table 1."""
    origin = made(report, store)
    if origin is None:
        raise Unmade(f"{report} is of no job in the store")
    jobs = list(ancestry(origin, store))
    body = []
    for stage in in_order(job.stage for job in jobs):
        noted = [facts(job, store) for job in jobs if job.stage == stage]
        wall, cpu = (
            sum(fact.get(name, 0.0) for fact in noted) / 60 for name in ("wall_s", "cpu_s")
        )
        threads = max(fact.get("threads", 1) for fact in noted)
        body.append(
            [stage_title(stage), str(len(noted)), str(threads), f"{wall:.1f}", f"{cpu:.1f}"]
        )
    heads = ["stage", "jobs", "threads of a job", "wall time of all jobs [min]"]
    return grid([*heads, "processor time [min]"], body).markdown


@block("growth.csv", command="slider benchmark-growth --out reports/growth.csv")
def growth(report: Path, store: Store) -> str:
    """A table per curve: what grows across, quantities down."""
    shown = []
    for curve, rows in by(read(report), "curve").items():
        counts = distinct(rows, "count")
        body = []
        for name, own in by(rows, "name").items():
            found = {row["count"]: f"{row['value']:.3g}" for row in own}
            body.append([name, *(found.get(count, "") for count in counts)])
        shown.append(grid([curve, *(f"{count:g}" for count in counts)], body).markdown)
    return "\n\n".join(shown)


_Line = tuple[str, str, Sequence[Row], str]
"""What, whose, the rows of one controller, and the column."""


def _group(rows: Sequence[Row], name: str, title: str = "") -> list[_Line]:
    """A line per controller; the first one has the title of the quantity."""
    heading = title or QUANTITIES[name].heading
    groups = by(rows, "label").items()
    return [
        ("" if index else heading, label, mine, name) for index, (label, mine) in enumerate(groups)
    ]


def _across(rows: Iterable[Row], lines: Iterable[_Line]) -> str:
    """Commands across: those of some rows."""
    commands = distinct(rows, "command_velocity")
    body = []
    for title, whose, mine, name in lines:
        found = {row["command_velocity"]: row for row in mine}
        body.append([title, whose, *(_cell(found.get(v, {}), name) for v in commands)])
    return grid(["command [m/s]", "", *map(speed, commands)], body).markdown


def _cell(row: Row, name: str) -> str:
    ends = ("success_low", "success_high") if name == "success_rate" else ()
    if not row:
        return QUANTITIES[name].text(NAN)
    return QUANTITIES[name].between(row[name], *([row[end] for end in ends] or (NAN, NAN)))


def _whole(report: Path) -> str:
    """A Markdown report without title and figure; its headings become bold lines."""
    first, *others = _parts(report)
    shown = [first[1], *(f"**{title}**\n\n{text}" for title, text in others)]
    return "\n\n".join(text for text in shown if text)


def _parts(report: Path) -> list[tuple[str, str]]:
    """Headings of a Markdown report and the text below each, without pictures."""
    parts = f"\n{report.read_text(encoding='utf-8')}".split("\n#")[1:]
    found = []
    for part in parts:
        title, _, text = part.partition("\n")
        items = [item.strip("\n") for item in text.split("\n\n")]
        kept = [item for item in items if item and not item.startswith("![")]
        found.append((title.lstrip("# "), "\n\n".join(kept)))
    return found
