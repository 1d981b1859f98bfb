"""Gaits of the default configuration that are really solved, once per test session."""

from pathlib import Path

from pipeline.stages.gaits import gait_section, library_job
from slider.core.job import Job
from slider.gait import stage as gait_stage
from slider.library import stage as library_stage
from tests import shared
from tests.config.composed import composed
from tests.gait.gaits import STEP_TIME

Velocity = tuple[float, float, float]


@shared.shared
def solved_gait(velocity: Velocity, dynamics: str = "prismatic") -> Path:
    """Object folder of a gait."""
    out = shared.new_folder()
    section = gait_section(composed(STEP_TIME, f"gait.dynamics={dynamics}"))
    gait_stage.run(section | {"velocity": [*velocity]}, {}, out, Job(out))
    return out


@shared.shared
def solved_library(velocities: tuple[Velocity, ...], dynamics: str = "prismatic") -> Path:
    """Object folder of a library."""
    gaits = [solved_gait(velocity, dynamics) for velocity in velocities]
    out = shared.new_folder()
    section = dict(library_job(composed(STEP_TIME, f"gait.dynamics={dynamics}")).section)
    library_stage.run(section, {"gaits": gaits}, out, Job(out))
    return out
