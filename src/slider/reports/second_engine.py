"""The stage ``second_engine``: the same controllers, starts and metrics in MuJoCo and in Drake."""

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from slider.core.job import Inputs, Job, Section, Summary
from slider.core.quantities import speed_text
from slider.core.tables import Table
from slider.evaluation import AUDIT
from slider.reports import report
from slider.reports.report import across

COMPARED = ("success_rate", "mse_steady", "tracking_rate", "slip", "penetration")
_SIZES = ("difference", "allowed")
_FALLEN = ("success_rate", "mse_steady", "slip")
_CAPTION = """\
{trials} trials of {robots} robots per controller and command, {duration:g} s from rest, in both
engines from the same starts. Errors, slip and depth are those of robots that stay up.
`second_engine.csv` has all numbers, and how the robots walk.
"""
_AUDIT = """\
Worst part of each quantity in the audit of Drake's model (of the first contact above), by MuJoCo's
numbers, in SI units. A difference beyond what is allowed stops the evaluations.
"""


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write ``second_engine.csv`` and ``second_engine.md``."""
    ours = report.results(report.load(inputs["evaluations"], section["labels"]))
    engines = pd.DataFrame(section["engines"], columns=["engine", "friction"])
    frame = pd.concat([engines, ours], axis=1)
    audit = json.loads((inputs["audits"][0] / AUDIT).read_text(encoding="utf-8"))
    body = [[one["quantity"], one["part"], *(f"{one[k]:.1g}" for k in _SIZES)] for one in audit]
    audited = Table(["quantity", "part", *_SIZES], body, "Audit")
    shown = _tables(frame, section["friction"])
    parts = [_CAPTION.format(**section["protocol"]), *shown, _AUDIT, audited]
    report.write(out / "second_engine", "Second engine", section["robot"], frame, parts)
    return {"rows": len(frame)}


def _tables(frame: pd.DataFrame, friction: float) -> Iterator[Table]:
    """All commands at the robot's friction; all frictions, where other frictions were tested."""
    usual, keys = frame["friction"] == friction, ["label", "engine"]
    yield across("Commands", "command [m/s]", "speed", COMPARED, frame[usual], keys)
    places = pd.MultiIndex.from_frame(frame[["controller", "speed"]])
    others = frame[places.isin(places[~usual])]
    title = f"Frictions, {', '.join(map(speed_text, np.sort(others['speed'].unique())))} m/s"
    yield across(title, "friction", "friction", _FALLEN, others, keys)
