"""The stage ``library``: collect all gaits in one Zarr store."""

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import zarr

from slider.config.convert import from_dict
from slider.config.gait import LibraryConfig
from slider.core.errors import UserError
from slider.core.job import Inputs, Job, Section, Summary
from slider.gait import REPORT
from slider.library.reader import (
    ARRAYS,
    CONSTRAINT,
    COORDINATES,
    LABELS,
    ORIGIN,
    SCHEMA,
    STORE,
    VERSION,
)
from slider.robot.names import CHANNEL_UNITS, CHANNELS, VELOCITY, velocity_text

_TEXT = np.dtypes.StringDType()
_SCALARS = ("cost", "max_violation", "iterations")

Report = dict[str, Any]


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Stack converged gaits in the order of the velocities.

    Raises:
        UserError: gaits did not converge and ``library.allow_holes`` is off.
    """
    config = from_dict(LibraryConfig, section["library"])
    folders = list(inputs["gaits"])
    reports = [json.loads((folder / REPORT).read_text(encoding="utf-8")) for folder in folders]
    good = [i for i, report in enumerate(reports) if acceptable(report, config.max_violation)]
    holes = [report for i, report in enumerate(reports) if i not in good]
    _log(reports, job)
    if not good or (holes and not config.allow_holes):
        raise UserError(_describe(holes, len(good)))
    about = {name: section[name] for name in ORIGIN}
    about["holes"] = [_hole(report, config) for report in holes]
    about["cost_unit"] = reports[good[0]]["cost_unit"]
    write_library(out / STORE, [folders[i] for i in good], [reports[i] for i in good], about)
    return {
        "gaits": len(good),
        "holes": [_velocity(report) for report in holes],
        "max_violation": max(reports[i]["max_violation"] for i in good),
    }


def write_library(
    path: Path, folders: Sequence[Path], reports: Sequence[Report], about: dict[str, Any]
) -> None:
    """Write gaits to a Zarr store; the same gaits give the same bytes.

    ``about`` holds the attributes ``ORIGIN`` and ``OUTCOME``. Zarr's settings are its defaults,
    whatever variables (``ZARR_…``) and files say.
    """
    with zarr.config.set(zarr.config.defaults[0]):
        group = zarr.open_group(path, mode="w", zarr_format=3)
        group.attrs.update(
            {
                "schema": SCHEMA,
                "version": VERSION,
                "channels": list(CHANNELS),
                "channel_units": list(CHANNEL_UNITS),
                "passive_channels": [i for i, name in enumerate(CHANNELS) if "upper_foot" in name],
                "coordinates": " ".join(COORDINATES),  # as xarray reads it
                **about,
            }
        )
        for name, values, axes, unit in _arrays(folders, reports):
            array = group.create_array(name, data=values, chunks=values.shape, dimension_names=axes)
            array.attrs["units"] = unit


def _arrays(
    folders: Sequence[Path], reports: Sequence[Report]
) -> Iterator[tuple[str, np.ndarray, tuple[str, ...], str]]:
    """Name, values, axes and unit of each array of the store."""
    constraints = list(reports[0]["residuals"])
    from_reports = {name: _column(reports, name) for name in _SCALARS}
    from_reports["velocities"] = np.array([_velocity(report) for report in reports])
    residuals = [[report["residuals"][name] for name in constraints] for report in reports]
    from_reports["residuals"] = np.array(residuals)
    for name, array in ARRAYS.items():
        values = from_reports.get(name)
        if values is None:
            values = np.stack([np.load(folder / f"{name}.npy") for folder in folders])
        yield name, values, ("gait", *array.axes), array.unit
    for name, array in COORDINATES.items():
        yield name, _column(reports, name), ("gait",), array.unit
    for name, labels in (LABELS | {CONSTRAINT: tuple(constraints)}).items():
        yield name, np.array(labels, dtype=_TEXT), (name,), "name"


def _velocity(report: Report) -> list[float]:
    return [report[name] for name in VELOCITY]


def _column(reports: Sequence[Report], name: str) -> np.ndarray:
    values = [report[name] for report in reports]
    return np.array(values, dtype=_TEXT) if isinstance(values[0], str) else np.array(values)


def _hole(report: Report, config: LibraryConfig) -> dict[str, Any]:
    """Attributes of a gait that did not converge, with the constraints that it violates."""
    names = (*VELOCITY, "status", "iterations", "max_violation")
    violated = [name for name, v in report["residuals"].items() if v > config.max_violation]
    worst_first = sorted(violated, key=lambda name: -report["residuals"][name])
    return {name: report[name] for name in names} | {
        "violated": [_beyond(report, name) for name in worst_first]
    }


def _beyond(report: Report, name: str) -> str:
    """A constraint, its worst value and its bound."""
    return f"{name} {report['worst'][name]} ({report['residuals'][name]:.1e} beyond)"


def acceptable(report: Mapping[str, Any], max_violation: float) -> bool:
    """Whether a gait counts as converged: for IPOPT, and by its worst residual."""
    return report["converged"] and report["max_violation"] <= max_violation


def _describe(holes: Sequence[Report], good: int) -> str:
    """One line: gaits that did not converge, their worst constraints, and how to go on."""
    texts = []
    for report in holes:
        name = max(report["residuals"], key=report["residuals"].__getitem__)
        velocity = velocity_text(_velocity(report))
        texts.append(f"{velocity} {report['status']}, {_beyond(report, name)}")
    list_ = "; ".join(texts)
    if not good:
        return f"library: expected at least one gait, none of {len(holes)} converged: {list_}"
    return (
        f"library: {len(holes)} of {len(holes) + good} gaits did not converge: {list_}; to go on "
        "without them: --config hydra='library.allow_holes=true'; their velocities then get gaits "
        "interpolated from those around them, or the nearest at the border"
    )


def _log(reports: Sequence[Report], job: Job) -> None:
    columns = (*VELOCITY, "status", "iterations", "cost", "max_violation")
    table: dict[str, list[Any]] = {name: [r[name] for r in reports] for name in columns}
    volatile = job.input_volatile.get("gaits", [{}] * len(reports))
    table["solve_cpu"] = [facts.get("solve_cpu") for facts in volatile]
    job.tracker.log_table(table, "gaits")
