"""The stage ``library``: collect all gaits in one Zarr store."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import zarr

from slider.core.config.convert import from_dict
from slider.core.config.gait import LibraryConfig
from slider.core.errors import UserError
from slider.core.job import Inputs, Job, Section, Summary
from slider.library.schema import ARRAYS, AXES, SCHEMA, UNITS, VERSION
from slider.robot.names import CHANNEL_UNITS, CHANNELS

STORE = "library.zarr"
_REPORT = "report.json"

Report = dict[str, Any]


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Stack converged gaits in the order of the velocities.

    Raises:
        UserError: gaits did not converge and ``library.allow_holes`` is off.
    """
    config = from_dict(LibraryConfig, section["library"])
    folders = list(inputs["gaits"])
    reports = [json.loads((folder / _REPORT).read_text()) for folder in folders]
    good = [i for i, report in enumerate(reports) if _acceptable(report, config)]
    holes = [report for i, report in enumerate(reports) if i not in set(good)]
    _log(reports, job)
    if not good or (holes and not config.allow_holes):
        raise UserError(_describe(holes))
    write_library(out / STORE, [folders[i] for i in good], [reports[i] for i in good])
    return {
        "gaits": len(good),
        "holes": [[report["vx"], report["vy"]] for report in holes],
        "max_violation": max(reports[i]["max_violation"] for i in good),
    }


def write_library(path: Path, folders: Sequence[Path], reports: Sequence[Report]) -> None:
    """Write gaits to a Zarr store; the same gaits give the same bytes."""
    group = zarr.open_group(path, mode="w", zarr_format=3)
    group.attrs.update(
        {
            "schema": SCHEMA,
            "version": VERSION,
            "channels": list(CHANNELS),
            "channel_units": list(CHANNEL_UNITS),
            "passive_channels": [i for i, name in enumerate(CHANNELS) if "upper_foot" in name],
            "status": [report["status"] for report in reports],
        }
    )
    scalars = {
        "velocities": np.array([[report["vx"], report["vy"]] for report in reports]),
        "cost": np.array([report["cost"] for report in reports]),
        "max_violation": np.array([report["max_violation"] for report in reports]),
        "iterations": np.array([report["iterations"] for report in reports]),
    }
    for name in ARRAYS:
        values = scalars.get(name)
        if values is None:
            values = np.stack([np.load(folder / f"{name}.npy") for folder in folders])
        array = group.create_array(
            name, data=values, chunks=values.shape, dimension_names=("gait", *AXES[name])
        )
        array.attrs["units"] = UNITS[name]


def _acceptable(report: Report, config: LibraryConfig) -> bool:
    return report["converged"] and report["max_violation"] <= config.max_violation


def _describe(holes: Sequence[Report]) -> str:
    """One line with the gaits that did not converge and their worst constraints."""
    texts = []
    for report in holes:
        name, value = max(report["residuals"].items(), key=lambda item: item[1])
        texts.append(
            f"({report['vx']:g}, {report['vy']:g}) m/s {report['status']}, {name} {value:.1e}"
        )
    return (
        f"library: {len(holes)} gaits did not converge: {'; '.join(texts)}; "
        "set library.allow_holes=true to go on without them"
    )


def _log(reports: Sequence[Report], job: Job) -> None:
    columns = ("vx", "vy", "status", "iterations", "cost", "max_violation")
    table: dict[str, list[Any]] = {name: [r[name] for r in reports] for name in columns}
    volatile = job.input_volatile.get("gaits", [{}] * len(reports))
    table["solve_cpu"] = [facts.get("solve_cpu") for facts in volatile]
    job.tracker.log_table(table, "gaits")
