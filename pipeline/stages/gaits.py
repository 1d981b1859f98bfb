"""Gaits, one per velocity of the grid, their library, and computations for each gait in it.

Controllers like ``hzd`` need the foot placement; Table 1 depends on no other check of the gaits.
"""

from dataclasses import fields
from itertools import product
from typing import Any

from pipeline.stages.entries import job, only, robot, without
from slider.artefacts.plan import JobSpec
from slider.config.convert import to_dict
from slider.config.gait import Axis, FormulationConfig, GridConfig, SolveConfig, axis_size
from slider.config.robot import Mechanism
from slider.config.schema import Config
from slider.core.errors import one_of
from slider.core.machine import kernels
from slider.verification.quantities import QUANTITIES

Velocity = tuple[float, float, float]
ANCHORS = 0.2  # spacing of anchors: straight gaits solved without another gait as a start [m/s]
_BESIDE = ("steps", "chunk")  # settings that foot placement does not use
_COLLECTED = ("on_failure", "bounds")  # settings only for the collection of checks


def library_job(config: Config) -> JobSpec:
    """The gait library, with all gaits as inputs."""
    shared = gait_section(config)
    gaits = [gait(shared, velocity) for velocity in velocities(config.gait.grid)]
    section = {
        "library": to_dict(config.library),
        # Written into the library beside the gaits.
        "robot": mechanism(config),
        **only(to_dict(config.gait), "dynamics", "cost", "kinematic_map"),
    }
    return job("library", "gait library", section, {"gaits": gaits})


def velocities(grid: GridConfig) -> list[Velocity]:
    """Sorted, distinct commands (vx [m/s], vy [m/s], yaw rate [rad/s]) of a grid."""

    def values(axis: Axis | list[float]) -> list[float]:
        """Values rounded to 1e-10, so that grids with different steps share gaits; no −0."""
        if isinstance(axis, Axis):
            axis = [axis.start + index * axis.step for index in range(axis_size(axis))]
        return [round(value, 10) + 0.0 for value in axis]

    blocks = [map(values, block.axes) for block in (grid, *grid.extra)]
    return sorted({(vx, vy, yaw_rate) for axes in blocks for vx, vy, yaw_rate in product(*axes)})


def mechanism(config: Config) -> dict[str, Any]:
    """The parts of the robot that gaits depend on."""
    return only(to_dict(config.robot), *(f.name for f in fields(Mechanism)))


def gait_section(config: Config) -> dict[str, Any]:
    """Section shared by all gaits, without the gains of the simulated drives and the grid."""
    settings = to_dict(config.gait)
    return {
        "robot": mechanism(config),
        "formulation": only(settings, *(f.name for f in fields(FormulationConfig))),
        "solve": only(settings, *(f.name for f in fields(SolveConfig))),
        "numerics": kernels(),
    }


def gait(shared: dict[str, Any], velocity: Velocity) -> JobSpec:
    """One gait, warm-started from its anchor, so that it does not depend on the grid."""
    vx, vy, yaw_rate = velocity
    turn = f" {yaw_rate:+.2f} rad/s" if yaw_rate else ""
    anchor = round(round(vx / ANCHORS) * ANCHORS, 10) + 0.0, 0.0, 0.0
    inputs = {} if velocity == anchor else {"anchor": [gait(shared, anchor)]}
    label = f"gait {vx:.2f} {vy:+.2f} m/s{turn}"
    return job("gait", label, shared | {"velocity": [*velocity]}, inputs)


def verification_jobs(config: Config, library: JobSpec) -> dict[str, JobSpec]:
    """Verification of chunks of gaits, and its collection.

    Raises:
        UserError: a bound is for a quantity that is not verified.
    """
    for name in config.verification.bounds:
        one_of("verification.bounds", name, QUANTITIES)
    settings = to_dict(config.verification)
    section = {
        "robot": robot(config),
        "posture": to_dict(config.gait.posture),
        "verification": without(settings, "chunk", *_COLLECTED),
        "numerics": kernels(),
    }
    size = config.verification.chunk
    gaits = _chunks("verification_gaits", "verification", section, library, size)
    section = {"verification": only(settings, *_COLLECTED)}
    inputs = {"library": [library], "gaits": gaits}
    return {"verification": job("verification", "verification", section, inputs)}


def stability_jobs(config: Config, library: JobSpec) -> dict[str, JobSpec]:
    """Foot placement from the linearised gaits, for controllers, and a table of their stability."""
    alone = {"library": [library]}
    section = {"hzd": without(to_dict(config.hzd), *_BESIDE), "numerics": kernels()}
    gaits = _chunks("stability_gaits", "foot placement", section, library, config.hzd.chunk)
    placement = job("foot_placement", "foot placement", {}, alone | {"gaits": gaits})
    table = job("stability", "stability", {}, alone | {"gaits": gaits})
    return {"foot_placement": placement, "stability": table}


def _chunks(
    stage: str, title: str, section: dict[str, Any], library: JobSpec, size: int
) -> list[JobSpec]:
    """Jobs of a stage, each for ``size`` gaits of the library."""
    velocities = [gait.section["velocity"] for gait in library.inputs["gaits"]]
    jobs = []
    for chunk in (velocities[start : start + size] for start in range(0, len(velocities), size)):
        label = f"{title} of {len(chunk)} gaits from {chunk[0][0]:.2f} m/s"
        inputs = {"library": [library]}
        jobs.append(job(stage, label, section | {"velocities": chunk}, inputs, tracked=False))
    return jobs
