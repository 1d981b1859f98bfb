"""Gaits, one per velocity of the grid, and their library."""

from dataclasses import fields
from itertools import product
from typing import Any

from pipeline.stages.entries import job
from pipeline.stages.sections import only
from slider.artefacts.plan import JobSpec
from slider.config.convert import to_dict
from slider.config.gait import Axis, FormulationConfig, GridConfig, SolveConfig, axis_size
from slider.config.robot import Mechanism
from slider.config.schema import Config
from slider.core.machine import kernels

Velocity = tuple[float, float, float]


def library_job(config: Config) -> JobSpec:
    """The gait library, and with it all gaits."""
    shared = gait_section(config)
    gaits = [gait(shared, velocity) for velocity in velocities(config.gait.grid)]
    return gait_library(config, gaits)


def velocities(grid: GridConfig) -> list[Velocity]:
    """Commands (vx [m/s], vy [m/s], yaw rate [rad/s]) of a grid, each once, sorted."""
    blocks = [map(_values, block.axes) for block in (grid, *grid.extra)]
    return sorted({(vx, vy, yaw_rate) for axes in blocks for vx, vy, yaw_rate in product(*axes)})


def _values(axis: Axis | list[float]) -> list[float]:
    """Values rounded to 1e-10, so that grids of other steps share their gaits; no −0."""
    if isinstance(axis, Axis):
        axis = [axis.start + index * axis.step for index in range(axis_size(axis))]
    return [round(value, 10) + 0.0 for value in axis]


def mechanism(config: Config) -> dict[str, Any]:
    """What gaits depend on of the robot."""
    return only(to_dict(config.robot), *(f.name for f in fields(Mechanism)))


def gait_section(config: Config) -> dict[str, Any]:
    """What all gaits share: neither the gains of the simulated drives nor the grid."""
    settings = to_dict(config.gait)
    return {
        "robot": mechanism(config),
        "formulation": only(settings, *(f.name for f in fields(FormulationConfig))),
        "solve": only(settings, *(f.name for f in fields(SolveConfig))),
        "numerics": kernels(),
    }


def gait(shared: dict[str, Any], velocity: Velocity) -> JobSpec:
    """One gait; it does not know of the other velocities."""
    vx, vy, yaw_rate = velocity
    turn = f" {yaw_rate:+.2f} rad/s" if yaw_rate else ""
    label = f"gait {vx:.2f} {vy:+.2f} m/s{turn}"
    return job("gait", label, shared | {"velocity": list(velocity)})


def gait_library(config: Config, gaits: list[JobSpec]) -> JobSpec:
    """All gaits in one store."""
    section = {
        "library": to_dict(config.library),
        # Written into the library, which so says what its gaits were made for and with.
        "robot": mechanism(config),
        **only(to_dict(config.gait), "dynamics", "transcription", "cost", "kinematic_map"),
    }
    return job("library", "gait library", section, {"gaits": gaits})


def chunks(library: JobSpec, size: int) -> list[list[list[float]]]:
    """Commands of a library's gaits, so many at a time."""
    velocities = [gait.section["velocity"] for gait in library.inputs["gaits"]]
    return [velocities[start : start + size] for start in range(0, len(velocities), size)]
