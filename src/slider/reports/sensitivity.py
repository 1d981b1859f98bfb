"""The stage ``sensitivity``: what each changed parameter of the robot does, as table and figure."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from slider.core.job import Inputs, Job, Section, Summary
from slider.evaluation.results import Evaluation
from slider.evaluation.stage import folder_name
from slider.gait import REPORT
from slider.reports import rows as tables
from slider.reports.figures import sensitivity as figure
from slider.reports.figures.style import write_pictures
from slider.reports.rows import NAN, Row
from slider.reports.sensitivity_effects import NOMINAL, carrying, effects, nominals
from slider.reports.sensitivity_text import blocks
from slider.reports.table import document

NAME = "sensitivity"
ABOUT = ("parameter", "provenance", "unit", "nominal", "factor", "value")
GAIT = ("gait_converged", "gait_iterations", "gait_cost", "gait_cost_change")
POLICY = ("success_rate", "mse_steady", "mean_velocity")
COLUMNS = (*ABOUT, "command", *GAIT, *POLICY, "note")


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write ``sensitivity.csv``, ``.md``, ``.svg`` and ``.png``."""
    rows = read_rows(section, inputs)
    tables.write(rows, out / f"{NAME}.csv", COLUMNS)
    text = document("Sensitivity", blocks(rows, section, out / f"{NAME}.svg"))
    (out / f"{NAME}.md").write_text(text, encoding="utf-8")
    write_pictures(out / NAME, lambda: figure.draw(rows, section["change"]))
    for suffix in ("svg", "png", "csv"):
        job.tracker.log_file(out / f"{NAME}.{suffix}")
    found = effects(rows)
    return {"parameters": len(found), "carrying": len(carrying(found, nominals(rows)))}


def read_rows(section: Section, inputs: Inputs) -> list[Row]:
    """A row per changed robot and command, those of the unchanged robot first.

    Numbers are NaN where nothing was asked for or nothing is known: of a robot that cannot be, the
    cost of a gait that did not converge, the velocity of a policy that never survived.
    """
    unchanged: Row = dict.fromkeys(ABOUT, "") | {"parameter": NOMINAL, "factor": 1.0}
    rows = _rows(unchanged, section["nominal"], section, inputs)
    for variant in section["variants"]:
        about = {name: variant[name] for name in ABOUT}
        rows += _rows(about, variant, section, inputs)
    costs = {row["command"]: row["gait_cost"] for row in rows[: len(section["commands"])]}
    return [
        row | {"gait_cost_change": row["gait_cost"] / costs[row["command"]] - 1.0} for row in rows
    ]


def _rows(about: Row, made: Mapping[str, Any], section: Section, inputs: Inputs) -> list[Row]:
    rows: list[Row] = []
    for index, command in enumerate(section["commands"]):
        row = about | {"command": command, "note": made.get("note", "")}
        row |= _gait(made["gaits"], index, inputs["gaits"])
        rows.append(row | _policy(made["rollout"], command, inputs["rollouts"]))
    return rows


def _gait(places: Sequence[int], index: int, folders: Sequence[Path]) -> Row:
    if not places:
        return dict.fromkeys(GAIT, NAN)
    report = json.loads((folders[places[index]] / REPORT).read_text())
    converged = report["converged"]
    return {
        "gait_converged": float(converged),
        "gait_iterations": float(report["iterations"]),
        "gait_cost": float(report["cost"]) if converged else NAN,
    }


def _policy(place: int | None, command: float, folders: Sequence[Path]) -> Row:
    if place is None:
        return dict.fromkeys(POLICY, NAN)
    evaluation = Evaluation.load(folders[place] / folder_name(command))
    row = tables.table_row(evaluation) | tables.quality_row(evaluation)
    return {name: row[name] for name in POLICY}
