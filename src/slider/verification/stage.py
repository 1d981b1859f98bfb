"""The stages ``verification_gaits``, some gaits per job, and ``verification``, which collects."""

import importlib.util
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from slider.config.convert import from_dict
from slider.config.gait import Posture
from slider.config.robot import RobotConfig
from slider.config.verification import CheckConfig
from slider.core.errors import UserError
from slider.core.job import Inputs, Job, Section, Summary
from slider.library.reader import STORE, GaitLibrary
from slider.verification import neighbours, summary
from slider.verification.stored import StoredGait, gaits_of

RECORDS = "gaits.json"
CSV, JSON, MARKDOWN = (f"verification.{suffix}" for suffix in ("csv", "json", "md"))
_SHOWN = 5  # failures in the line that ends a job


def run_gaits(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Check the gaits of some commands; a hole of the library is left out.

    Raises:
        UserError: pinocchio is not installed.
    """
    if importlib.util.find_spec("pinocchio") is None:
        raise UserError("expected pinocchio, found none: pip install 'slider-ehzd[verify]'")
    from slider.verification import gaits

    library = GaitLibrary.load(inputs["library"][0] / STORE)
    table = gaits.checks(
        gaits.Surroundings(
            from_dict(RobotConfig, section["robot"]),
            from_dict(Posture, section["posture"]),
            library.dynamics,
            library.kinematic_map,
            from_dict(CheckConfig, section["verification"]),
        )
    )
    chosen = _choose(gaits_of(library), section["commands"])
    records, times = [], []
    for gait in chosen:
        values, seconds = gaits.check_gait(gait, table)
        records.append({"command": gait.commands.tolist(), "values": values})
        times.append(seconds)
        job.progress(f"{len(records)} of {len(chosen)} gaits")
    if times:
        job.volatile["seconds"] = {name: float(np.mean([t[name] for t in times])) for name in table}
    job.volatile["checked"] = len(records)
    (out / RECORDS).write_text(json.dumps(records, indent=1) + "\n")
    return {"gaits": len(records)}


def _choose(gaits: Sequence[StoredGait], commands: Sequence[Sequence[float]]) -> list[StoredGait]:
    by_command = {tuple(gait.commands): gait for gait in gaits}
    return [by_command[tuple(c)] for c in commands if tuple(c) in by_command]


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Add the checks between gaits, compare all values with their bounds and write the results.

    Raises:
        UserError: a bound is unknown, or does not hold and ``verification.on_failure`` is
            ``error``.
    """
    settings = section["verification"]
    bounds: summary.Bounds = settings["bounds"]
    summary.check_names(bounds)
    gaits = gaits_of(GaitLibrary.load(inputs["library"][0] / STORE))
    pairs = neighbours.smoothness(gaits, settings["reach"])
    rows = _rows(gaits, _records(inputs["gaits"]), pairs)
    failed = summary.failures(rows, bounds)
    if failed and settings["on_failure"] == "error":
        raise UserError(_describe(failed))
    quantities = summary.worst(rows, bounds)
    content = {
        "gaits": len(rows),
        "passed": not failed,
        "failures": [str(failure) for failure in failed],
        "quantities": quantities,
        "jumps": summary.describe_pairs(pairs, rows, bounds),
    }
    summary.write_csv(out / CSV, rows, failed)
    summary.write_json(out / JSON, content)
    summary.write_markdown(out / MARKDOWN, rows, quantities)
    _log(rows, out, job)
    return {"gaits": len(rows), "passed": not failed, "failures": len(failed)}


def _records(folders: Sequence[Path]) -> dict[tuple[float, ...], dict[str, float]]:
    records = [r for folder in folders for r in json.loads((folder / RECORDS).read_text())]
    return {tuple(record["command"]): record["values"] for record in records}


def _rows(
    gaits: Sequence[StoredGait],
    records: Mapping[tuple[float, ...], dict[str, float]],
    pairs: Sequence[neighbours.Pair],
) -> list[summary.Row]:
    rows = []
    for index, (gait, reflection) in enumerate(zip(gaits, neighbours.mirror(gaits), strict=True)):
        command = tuple(gait.commands.tolist())
        values = records[command] | reflection | neighbours.jumps_of(pairs, index)
        rows.append(summary.Row(command, values))
    return rows


def _describe(failed: Sequence[summary.Failure]) -> str:
    texts = [str(failure) for failure in failed[:_SHOWN]]
    more = f"; and {len(failed) - _SHOWN} more" if len(failed) > _SHOWN else ""
    return (
        f"{len(failed)} bounds do not hold: {'; '.join(texts)}{more} "
        "(verification.on_failure=report writes the table all the same)"
    )


def _log(rows: Sequence[summary.Row], out: Path, job: Job) -> None:
    """Times per gait [s] go to the volatile facts, the table to the tracker."""
    facts: list[Mapping[str, Any]] = [
        f for f in job.input_volatile.get("gaits", []) if "seconds" in f
    ]
    weights = [f["checked"] for f in facts]
    if sum(weights):
        names = facts[0]["seconds"]
        job.volatile["seconds"] = {
            n: float(np.average([f["seconds"][n] for f in facts], weights=weights)) for n in names
        }
    job.tracker.log_file(out / CSV)
    job.tracker.log_file(out / JSON)
