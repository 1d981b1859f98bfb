"""The tables of the documentation by the name of their block, each from one report."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from slider.artefacts.store import Store
from slider.reports.comparison import read_rows
from slider.reports.controllers import label, speed
from slider.reports.protocols.speeds import TRACKED_SHARE, highest_tracked
from slider.reports.results.cases import heldout
from slider.reports.results.commands import robust, table1
from slider.reports.results.documents import ablation, sensitivity
from slider.reports.results.markdown import grid, markdown
from slider.reports.results.quality import quality
from slider.reports.results.seeds import seeds
from slider.reports.results.times import times
from slider.reports.sections.verification import bounds_table


@dataclass(frozen=True)
class ResultTable:
    """A table of the documentation.

    Attributes:
        report: file of ``reports/`` that it is made from.
        make: Markdown from that file; the store says more where the file is not enough.
        target: file to ask Snakemake for, where it is another one.
    """

    report: str
    make: Callable[[Path, Store], str]
    target: str = ""


def sweep(report: Path, store: Store) -> str:
    """Highest speed that each controller tracks, and lower ones that it does not."""
    rows = read_rows(report)
    body = []
    for controller, highest in highest_tracked(rows).items():
        lost = [
            speed(float(row["command_velocity"]))
            for row in rows
            if row["controller"] == controller
            and float(row["command_velocity"]) < (highest or 0.0)
            and float(row["tracking_rate"]) < TRACKED_SHARE
        ]
        found = "none" if highest is None else speed(highest)
        body.append([label(controller), found, ", ".join(lost) or "none"])
    heads = ["controller", "highest tracked speed [m/s]", "lower speeds that it does not track"]
    return markdown(grid(heads, body))


def verification(report: Path, store: Store) -> str:
    """How many bounds hold, and worst value, gait, median and bound of each quantity."""
    about = json.loads(report.read_text(encoding="utf-8"))
    bounded = [found for found in about["quantities"].values() if found["bound"] is not None]
    held = sum(bool(found["passed"]) for found in bounded)
    intro = f"{about['gaits']} gaits; {held} of {len(bounded)} bounds hold for all of them."
    return f"{intro}\n\n{markdown(bounds_table(about['quantities']))}"


TABLES = {
    "table1": ResultTable("table1.csv", table1),
    "quality": ResultTable("gait_quality.csv", quality),
    "heldout": ResultTable("heldout.csv", heldout),
    "sweep": ResultTable("sweep.csv", sweep),
    "robust": ResultTable("robust.csv", robust),
    "seeds": ResultTable("seeds.csv", seeds),
    "ablation": ResultTable("ablation.md", ablation, "ablation.csv"),
    "sensitivity": ResultTable("sensitivity.md", sensitivity, "sensitivity.csv"),
    "verification": ResultTable("verification.json", verification, "verification.csv"),
    "times": ResultTable("table1.csv", times),
}
"""Name of a block → its table."""
