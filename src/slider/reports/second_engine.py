"""The stage ``second_engine``: the same controllers, starts and metrics in MuJoCo and in Drake."""

import json
from collections.abc import Iterator, Sequence
from pathlib import Path

from slider.core.job import Inputs, Job, Section, Summary
from slider.core.tables import Table
from slider.evaluation.drake import AUDIT
from slider.reports import rows as tables
from slider.reports.document import write_document
from slider.reports.quantities import NONE, QUANTITIES, speed_text
from slider.reports.rows import Row, by, distinct

COMPARED = ("success_rate", "mse_steady", "tracking_rate", "slip", "penetration", "contact_rate")
_SIZES = ("difference", "allowed")
_FALLEN = ("success_rate", "mse_steady", "slip")
_CAPTION = """\
{trials} trials of {robots} robots per controller and command, {duration:g} s from rest, in both
engines from the same starts. Errors, slip and depth are those of robots that stay up.
`second_engine.csv` has all numbers, and how the robots walk.
"""
_AUDIT = """\
Worst part of each quantity in the audit of Drake's model, by MuJoCo's numbers, in SI units. A
difference beyond what is allowed stops the evaluations.
"""


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write ``second_engine.csv`` and ``second_engine.md``."""
    evaluations = tables.evaluations(inputs["evaluations"], section["labels"])
    rows = [
        {"engine": engine, "friction": friction} | tables.table_row(one) | tables.quality_row(one)
        for (engine, friction), one in zip(section["engines"], evaluations, strict=True)
    ]
    tables.write(rows, out / "second_engine.csv")
    audit = json.loads((inputs["audit"][0] / AUDIT).read_text(encoding="utf-8"))
    body = [[one["quantity"], one["part"], *(f"{one[k]:.1g}" for k in _SIZES)] for one in audit]
    audited = Table(["quantity", "part", *_SIZES], body, "Audit")
    shown = [across(*parts).markdown for parts in _parts(rows, section["friction"])]
    parts = [_CAPTION.format(**section["protocol"]), *shown, _AUDIT, audited.markdown]
    write_document(out / "second_engine.md", "Second engine", section["robot"], parts)
    return {"rows": len(rows)}


def _parts(rows: Sequence[Row], friction: float) -> Iterator[tuple]:
    """All commands with the robot's friction; frictions of the controllers that walk on others."""
    usual = [row for row in rows if row["friction"] == friction]
    yield "Commands", "command [m/s]", "speed", COMPARED, usual
    others = [row for row in rows if row["friction"] != friction]
    places = {(row["controller"], row["speed"]) for row in others}
    first = [row for row in usual if (row["controller"], row["speed"]) in places]
    title = f"Frictions, {', '.join(map(speed_text, distinct(others, 'speed')))} m/s"
    yield title, "friction", "friction", _FALLEN, [*first, *others]


def across(
    title: str, head: str, column: str, quantities: Sequence[str], rows: Sequence[Row]
) -> Table:
    """Quantities, controllers and engines down, the values of a column across."""
    values, body = distinct(rows, column), []
    for name in quantities:
        heading = QUANTITIES[name].heading
        for (label, engine), mine in by(rows, "label", "engine").items():
            cells = {row[column]: QUANTITIES[name].text(row[name]) for row in mine}
            body.append([heading, label, engine, *(cells.get(value, NONE) for value in values)])
            heading = ""
    return Table([head, "", "", *(f"{value:g}" for value in values)], body, title)
