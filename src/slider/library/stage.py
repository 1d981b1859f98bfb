"""The stage ``library``: collect all gaits in one Zarr store."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import zarr

from slider.config.convert import from_dict
from slider.config.gait import LibraryConfig
from slider.config.robot import Mechanism
from slider.core.errors import UserError
from slider.core.job import Inputs, Job, Section, Summary
from slider.gait import REPORT
from slider.library import reader
from slider.robot import names
from slider.robot.names import VELOCITY, velocity_text

_TEXT = np.dtypes.StringDType()
_SCALARS = ("cost", "max_violation", "iterations")

Report = dict[str, Any]


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Stack converged gaits in the order of the velocities.

    Raises:
        UserError: gaits did not converge and ``library.allow_holes`` is off.
    """
    config = from_dict(LibraryConfig, section["library"])
    folders = inputs["gaits"]
    reports = [json.loads((folder / REPORT).read_text(encoding="utf-8")) for folder in folders]
    good = [i for i, report in enumerate(reports) if acceptable(report, config.max_violation)]
    holes = [report for i, report in enumerate(reports) if i not in good]
    if not good or (holes and not config.allow_holes):
        raise UserError(_describe(holes, len(good)))
    attributes = {name: section[name] for name in reader.ORIGIN}
    attributes["holes"] = [_hole(report, config.max_violation) for report in holes]
    attributes["cost_unit"] = reports[good[0]]["cost_unit"]
    _write(out / reader.STORE, [folders[i] for i in good], [reports[i] for i in good], attributes)
    return {
        "gaits": len(good),
        "holes": [_velocity(report) for report in holes],
        "max_violation": max(reports[i]["max_violation"] for i in good),
    }


def acceptable(report: Mapping[str, Any], max_violation: float) -> bool:
    """Whether a gait counts as converged, by IPOPT's status and by its worst residual."""
    return report["converged"] and report["max_violation"] <= max_violation


def _write(
    path: Path, folders: Sequence[Path], reports: Sequence[Report], attributes: dict[str, Any]
) -> None:
    """Write gaits to a Zarr store; the same gaits give the same bytes.

    Zarr's defaults apply, whatever its environment variables (``ZARR_…``) and files say.
    """
    constraints = tuple(reports[0]["residuals"])
    geometry = from_dict(Mechanism, attributes["robot"], "robot").geometry
    passive = sorted({*range(names.NUM_JOINTS)} - {*names.driven_joints(geometry)})
    columns = {name: _column(reports, name) for name in (*_SCALARS, *reader.COORDINATES)}
    columns["velocities"] = np.array([_velocity(report) for report in reports])
    residuals = [[report["residuals"][name] for name in constraints] for report in reports]
    columns["residuals"] = np.array(residuals)
    with zarr.config.set(zarr.config.defaults[0]):
        group = zarr.open_group(path, mode="w", zarr_format=3)
        group.attrs.update(
            {
                "schema": reader.SCHEMA,
                "version": reader.VERSION,
                "channels": list(names.channels(geometry)),
                "channel_units": list(names.channel_units(geometry)),
                "passive_channels": [*passive, *(names.NUM_JOINTS + joint for joint in passive)],
                "coordinates": " ".join(reader.COORDINATES),  # as xarray reads it
                **attributes,
            }
        )

        def create(name: str, values: np.ndarray, axes: tuple[str, ...], unit: str) -> None:
            array = group.create_array(name, data=values, chunks=values.shape, dimension_names=axes)
            array.attrs["units"] = unit

        for name, array in (reader.ARRAYS | reader.COORDINATES).items():
            values = columns.get(name)
            if values is None:
                values = np.stack([np.load(folder / f"{name}.npy") for folder in folders])
            create(name, values, ("gait", *array.axes), array.unit)
        for name, values in (reader.labels(geometry) | {reader.CONSTRAINT: constraints}).items():
            create(name, np.array(values, dtype=_TEXT), (name,), "name")


def _velocity(report: Report) -> list[float]:
    return [report[name] for name in VELOCITY]


def _column(reports: Sequence[Report], name: str) -> np.ndarray:
    values = [report[name] for report in reports]
    return np.array(values, dtype=_TEXT if isinstance(values[0], str) else None)


def _hole(report: Report, max_violation: float) -> dict[str, Any]:
    """Attributes of a gait that did not converge, with the constraints that it violates."""
    kept = (*VELOCITY, "status", "iterations", "max_violation")
    residuals = report["residuals"]
    worst_first = sorted(residuals, key=lambda name: -residuals[name])
    violated = [_beyond(report, name) for name in worst_first if residuals[name] > max_violation]
    return {name: report[name] for name in kept} | {"violated": violated}


def _beyond(report: Report, name: str) -> str:
    """A constraint, its worst value and its bound."""
    return f"{name} {report['worst'][name]} ({report['residuals'][name]:.1e} beyond)"


def _describe(holes: Sequence[Report], good: int) -> str:
    """One line: gaits that did not converge, their worst constraints, and how to proceed."""
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
