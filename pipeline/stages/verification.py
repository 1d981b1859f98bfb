"""The independent checks of the library's gaits; nothing on the way to Table 1 needs them."""

from pipeline.stages.entries import job
from pipeline.stages.gaits import chunks
from pipeline.stages.sections import only, robot, without
from slider.artefacts.plan import JobSpec
from slider.config.convert import to_dict
from slider.config.schema import Config
from slider.core.errors import one_of
from slider.core.machine import kernels
from slider.verification.quantities import QUANTITIES

_COLLECTED = ("on_failure", "bounds")  # settings of the collection alone


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
