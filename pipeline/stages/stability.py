"""Stability of the gaits and foot placement; controllers like hzd need the latter."""

from pipeline.stages.entries import job
from pipeline.stages.gaits import chunks
from pipeline.stages.sections import without
from slider.artefacts.plan import JobSpec
from slider.config.convert import to_dict
from slider.config.schema import Config
from slider.core.machine import kernels

_BEYOND = ("impacts", "basin", "steps", "chunk")  # settings that foot placement does not use


def stability_jobs(config: Config, library: JobSpec) -> dict[str, JobSpec]:
    """What controllers take of the linearised gaits; tables, basins and figures for people."""
    shared = {"hzd": without(to_dict(config.hzd), *_BEYOND), "numerics": kernels()}
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
