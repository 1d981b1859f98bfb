"""The stage ``velocity_tracking``: forward velocity over time, as in the paper's figure."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from slider.core.errors import UserError
from slider.core.job import Inputs, Job, Section, Summary
from slider.evaluation.results import Evaluation
from slider.reports import rows as tables
from slider.reports.controllers import speed
from slider.reports.figures.velocity_tracking import draw
from slider.reports.protocols import write
from slider.reports.rows import NAN, Row
from slider.reports.table import Picture, Text, Written

NAME = "velocity_tracking"
CAPTION = (
    "Forward velocity from rest: mean over surviving robots, the band is one standard deviation "
    "between robots, dashed the command."
)


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write table, figure and Markdown of the asked commands.

    Raises:
        UserError: none of them is evaluated.
    """
    asked, period = section["commands"], section["control_period"]
    found = tables.evaluations(inputs["evaluations"], section["labels"])
    if not found:
        expected = "at least one of evaluation.commands"
        raise UserError(f"report.tracking_commands: expected {expected}, found {asked}")
    rows = [row for one in found for row in read_rows(one, period)]
    blocks = [Picture(out / f"{NAME}.svg"), Text(CAPTION), *notes(found, asked)]
    title = "Forward velocity over time"
    write(out / NAME, title, rows, lambda: draw(found, period), blocks, job)
    return {"rows": len(rows)}


def read_rows(one: Evaluation, period: float) -> list[Row]:
    """A row per control step: the time of its end [s], mean and spread over survivors [m/s]."""
    about = tables.named(one) | {"command_velocity": one.command}
    values = np.full_like(one.velocity, NAN) if fell(one) else one.velocity
    names = ("mean_velocity", "mean_velocity_spread")
    return [
        about | {"time": period * step} | dict(zip(names, map(float, pair), strict=True))
        for step, pair in enumerate(values, start=1)
    ]


def notes(found: Sequence[Evaluation], asked: Sequence[float]) -> Iterator[Written]:
    """What is not drawn, and why."""
    evaluated = {one.command for one in found}
    missing = ", ".join(speed(command) for command in asked if command not in evaluated)
    if missing:
        yield Text(f"Not evaluated in this run, and therefore not drawn: {missing} m/s.", "note")
    fallen = [
        f"{one.label} at {speed(one.command)} m/s"
        for one in found
        if one.command is not None and one.command in asked and fell(one)
    ]
    if fallen:
        yield Text(f"Nobody survived, and therefore not drawn: {'; '.join(fallen)}.", "note")


def fell(one: Evaluation) -> bool:
    """Nobody survived: there is nothing to draw."""
    return not one.robots.survived.any()
