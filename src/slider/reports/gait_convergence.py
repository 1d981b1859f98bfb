"""The stage ``gait_convergence``: gaits on several meshes and from random starts."""

import json
from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from slider.core.job import Inputs, Job, Section, Summary
from slider.gait import REPORT
from slider.gait.study import MeshGait, optima
from slider.library.stage import acceptable
from slider.reports import rows as tables
from slider.reports.figures import gait_convergence as figure
from slider.reports.figures.style import write_pictures
from slider.reports.gait_convergence_text import LIBRARY, TIME, blocks
from slider.reports.rows import NAN, Row
from slider.reports.table import document

NAME, STARTS = "gait_convergence", "gait_starts"


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write ``gait_convergence.csv``, ``.md``, ``.svg`` and ``.png``, and ``gait_starts.csv``.

    Processor times differ from run to run, so the Markdown alone has them.
    """
    meshes, starts = mesh_rows(section, inputs, job), start_rows(section, inputs, job)
    for rows, name in ((meshes, NAME), (starts, STARTS)):
        columns = [column for column in rows[0] if column != TIME]
        tables.write(rows, out / f"{name}.csv", columns)
        job.tracker.log_file(out / f"{name}.csv")
    written = blocks(meshes, starts, section["study"], out / f"{NAME}.svg")
    (out / f"{NAME}.md").write_text(document("Convergence of the gaits", written), encoding="utf-8")
    write_pictures(out / NAME, lambda: figure.draw(meshes, starts, section["study"]["same_cost"]))
    failed = (sum(row["converged"] == 0 for row in rows) for rows in (meshes, starts))
    return dict(zip(("failed_meshes", "failed_starts"), failed, strict=True))


def mesh_rows(section: Section, inputs: Inputs, job: Job) -> list[Row]:
    """A row per command and mesh; differences are from the command's finest mesh.

    They are NaN where one of the two gaits did not converge.
    """
    study, limit = section["study"], section["max_violation"]
    places = product(study["commands"], study["nodes"])
    gaits = [MeshGait.load(folder) for folder in inputs["meshes"]]
    rows = [
        {"command": command, "nodes": float(nodes)}
        | _outcome(report, limit)
        | {"torque_cost": gait.torque_cost, "step_time": gait.step_time}
        | {f"between_{name}": worst for name, worst in report["between_nodes"].items()}
        for (command, nodes), gait, report in zip(
            places, gaits, _reports(inputs, job, "meshes"), strict=True
        )
    ]
    finest = int(np.argmax(study["nodes"]))
    for first in range(0, len(rows), len(study["nodes"])):
        best = first + finest
        for place in range(first, first + len(study["nodes"])):
            both = rows[place]["converged"] and rows[best]["converged"]
            found = gaits[place].difference(gaits[best])
            rows[place] |= {n: value if both else NAN for n, value in found.items()}
    return rows


def start_rows(section: Section, inputs: Inputs, job: Job) -> list[Row]:
    """A row per command and start, the library's own gait first.

    Of starts that converge also the number of their optimum, 0 for the cheapest, and by which
    share they cost more than the cheapest of the command.
    """
    study, limit = section["study"], section["max_violation"]
    count, found = study["starts"]["number"], []
    own, starts = _reports(inputs, job, "library"), _reports(inputs, job, "starts")
    for place, command in enumerate(study["commands"]):
        mine = [own[place], *starts[place * count : (place + 1) * count]]
        names = [LIBRARY, *map(float, range(count))]
        rows = [
            {"command": command, "start": name} | _outcome(report, limit)
            for name, report in zip(names, mine, strict=True)
        ]
        found += _with_optima(rows, study["same_cost"])
    return found


def _with_optima(rows: Sequence[Row], same: float) -> list[Row]:
    good = np.array([row["converged"] > 0 for row in rows])
    costs = np.array([row["cost"] for row in rows])
    optimum, excess = np.full((2, len(rows)), NAN)
    if good.any():
        optimum[good] = optima(costs[good], same)
        excess[good] = costs[good] / costs[good].min() - 1.0
    return [
        row | {"optimum": float(number), "cost_excess": float(share)}
        for row, number, share in zip(rows, optimum, excess, strict=True)
    ]


def _outcome(report: Mapping[str, Any], limit: float) -> Row:
    residuals = report["residuals"]
    return {
        "converged": float(acceptable(report, limit)),
        "status": report["status"],
        "iterations": float(report["iterations"]),
        "cost": report["cost"],
        "max_violation": report["max_violation"],
        "worst_constraint": max(residuals, key=residuals.__getitem__),
        TIME: report[TIME],
    }


def _reports(inputs: Inputs, job: Job, name: str) -> list[dict[str, Any]]:
    """Reports of some solves, with the processor time [s] of each where it is known."""
    folders = inputs[name]
    facts = job.input_volatile.get(name, [{}] * len(folders))
    return [
        json.loads((folder / REPORT).read_text()) | {TIME: fact.get(TIME, NAN)}
        for folder, fact in zip(folders, facts, strict=True)
    ]
