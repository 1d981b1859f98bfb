"""Gaits, one per velocity of the grid, their library, and what is computed of each gait in it.

Controllers like ``hzd`` need the foot placement; no other check of a gait is on the way to Table 1.
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
_FOR_PEOPLE = ("impacts", "basin", "steps", "chunk")  # settings that foot placement does not use
_COLLECTED = ("on_failure", "bounds")  # settings of the collection of checks alone


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


def verification_jobs(config: Config, library: JobSpec) -> dict[str, JobSpec]:
    """Chunks of gaits, their collection, and maps of what it found.

    Raises:
        UserError: there is a bound of something that is not verified.
    """
    for name in config.verification.bounds:
        one_of("verification.bounds", name, QUANTITIES)
    size = config.verification.chunk
    gaits = [verification_of_gaits(config, chunk, library) for chunk in chunks(library, size)]
    section = {"verification": only(to_dict(config.verification), *_COLLECTED)}
    inputs = {"library": [library], "gaits": gaits}
    found = job("verification", "verification", section, inputs)
    inputs = {"library": [library], "verification": [found]}
    maps = job("verification_maps", "maps of the verification", {}, inputs)
    return {"verification": found, "verification_maps": maps}


def verification_of_gaits(
    config: Config, velocities: list[list[float]], library: JobSpec
) -> JobSpec:
    """The checks of some gaits."""
    section = {
        "robot": robot(config),
        "posture": to_dict(config.gait.posture),
        "verification": without(to_dict(config.verification), "chunk", *_COLLECTED),
        "velocities": velocities,
        "numerics": kernels(),
    }
    label = f"verification of {len(velocities)} gaits from {velocities[0][0]:.2f} m/s"
    return job("verification_gaits", label, section, {"library": [library]}, tracked=False)


def stability_jobs(config: Config, library: JobSpec) -> dict[str, JobSpec]:
    """What controllers take of the linearised gaits; tables, basins and figures for people."""
    shared = {"hzd": without(to_dict(config.hzd), *_FOR_PEOPLE), "numerics": kernels()}
    gaits = [_gaits(shared, chunk, library) for chunk in chunks(library, config.hzd.chunk)]
    impacts = to_dict(config.hzd.impacts)
    maps = [_maps(impacts, gait) for gait in gaits]
    table = job("stability", "stability", {}, {"gaits": maps})
    drawn = {"library": [library], "stability": [table]}
    velocities = [gait.section["velocity"] for gait in library.inputs["gaits"]]
    wanted = [gait for gait in to_dict(config.hzd.basin)["gaits"] if [*gait, 0.0] in velocities]
    if wanted:
        drawn["basins"] = [_basin(config, shared, [*gait, 0.0], library) for gait in wanted]
    return {
        "foot_placement": job(
            "foot_placement", "foot placement", {}, {"library": [library], "gaits": gaits}
        ),
        "stability": table,
        "stability_figures": job("stability_figures", "figures of stability", {}, drawn),
    }


def _gaits(shared: dict, velocities: list[list[float]], library: JobSpec) -> JobSpec:
    """Limit cycles and foot placement of some gaits."""
    section = shared | {"velocities": velocities}
    label = f"foot placement of {len(velocities)} gaits from {velocities[0][0]:.2f} m/s"
    return job("stability_gaits", label, section, {"library": [library]}, tracked=False)


def _maps(impacts: dict, gaits: JobSpec) -> JobSpec:
    """Return maps of the same gaits, for people."""
    label = gaits.label.replace("foot placement", "return maps", 1)
    inputs = {**gaits.inputs, "gaits": [gaits]}
    return job("return_maps", label, {**gaits.section, "impacts": impacts}, inputs, tracked=False)


def _basin(config: Config, shared: dict, gait: list[float], library: JobSpec) -> JobSpec:
    """Basin of attraction of one gait."""
    basin = without(to_dict(config.hzd.basin), "gaits")
    section = shared | {"basin": basin, "velocity": gait}
    label = f"basin of {gait[0]:.2f} {gait[1]:+.2f} m/s"
    return job("basin", label, section, {"library": [library]}, tracked=False)
