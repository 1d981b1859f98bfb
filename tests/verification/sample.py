"""A small library of real gaits, solved once per test session, and ways to spoil it."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import numpy as np

from pipeline.stages.gaits import gait_library, gait_section
from pipeline.stages.verification import verification_jobs
from slider.core.config.compose import compose
from slider.core.config.schema import Config
from slider.core.job import Job
from slider.core.plan import JobSpec
from slider.core.recipe import Code
from slider.gait import stage as gait_stage
from slider.library import stage as library_stage
from slider.robot.knee_model import build_knee_model
from slider.verification.gaits import Check, Surroundings, checks
from slider.verification.pin_robot import PinRobot
from slider.verification.stored import StoredGait, load_gaits

CONF = Path(__file__).parents[2] / "conf"
VELOCITIES = [(0.6, -0.1), (0.6, 0.1), (0.65, 0.1)]
SHORT = ("verification.replay.steps=3", "verification.points=21", "verification.chunk=2")


@cache
def config() -> Config:
    return compose(list(SHORT), CONF)


@cache
def library() -> Path:
    """Object folder of a library of three gaits."""
    folder = Path(mkdtemp(prefix="slider-verification-"))
    shared = gait_section(config())
    gaits = []
    for vx, vy in VELOCITIES:
        gaits.append(folder / f"gait {vx} {vy}")
        gaits[-1].mkdir()
        gait_stage.run(shared | {"velocity": [vx, vy]}, {}, gaits[-1], Job(folder))
    out = folder / "library"
    out.mkdir()
    section = gait_library(config(), []).section
    library_stage.run(section, {"gaits": gaits}, out, Job(folder))
    return out


@cache
def gaits() -> list[StoredGait]:
    return load_gaits(library() / "library.zarr")


@cache
def pinocchio() -> PinRobot:
    robot = config().robot
    return PinRobot(build_knee_model(robot.geometry, robot.links, robot.virtual_knee))


@cache
def table() -> dict[str, Check]:
    c = config()
    return checks(Surroundings(c.robot, c.gait.posture, c.gait.kinematic_map, c.verification))


def jobs() -> tuple[list[JobSpec], JobSpec]:
    """The jobs of the small library: those of some gaits each, and the one that collects."""
    velocities = [list(velocity) for velocity in VELOCITIES]
    source = JobSpec("library", "", Code("", "", {}), {"velocities": velocities})
    collect = verification_jobs(config(), source)["verification"]
    return list(collect.inputs["gaits"]), collect


def spoiled(gait: StoredGait, name: str, change: Callable[[np.ndarray], None]) -> StoredGait:
    """A gait with one of its arrays changed."""
    array = getattr(gait, name).copy()
    change(array)
    return replace(gait, **{name: array})
