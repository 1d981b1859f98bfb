"""A small library of real gaits, solved once per test session, and ways to spoil it."""

from collections.abc import Mapping
from dataclasses import fields, replace
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import numpy as np
import pandas as pd

from pipeline.stages.gaits import gait_section, verification_jobs
from slider.artefacts.plan import JobSpec
from slider.artefacts.recipe import Code
from slider.config.convert import to_dict
from slider.config.robot import Mechanism, RobotConfig
from slider.config.schema import Config
from slider.core.job import Job
from slider.gait import stage as gait_stage
from slider.library.reader import STORE, GaitLibrary
from slider.robot.names import VELOCITY
from slider.verification.pin_robot import PinRobot
from slider.verification.plant import Plant
from slider.verification.quantities import QUANTITIES
from slider.verification.stage import Check, check_gait, checks
from slider.verification.stored import StoredGait, gaits_of
from slider.verification.summary import judge
from tests import shared
from tests.config.composed import composed
from tests.library.solved import solved_library
from tests.robot.lopsided import soled

VELOCITIES = [(0.6, -0.1), (0.6, 0.1), (0.65, 0.1)]
SHORT = ("verification.points=21", "verification.chunk=2")


@cache
def config(*overrides: str) -> Config:
    return composed(*SHORT, *overrides)


def library() -> Path:
    """Object folder of a library of three gaits."""
    return solved_library(tuple((*velocity, 0.0) for velocity in VELOCITIES))


@cache
def gaits() -> list[StoredGait]:
    return gaits_of(GaitLibrary.load(library() / STORE))


@cache
def knee_gait() -> StoredGait:
    """A gait with the virtual knee's dynamics."""
    return gaits_of(GaitLibrary.load(solved_library(((0.6, 0.1, 0.0),), "knee") / STORE))[0]


@cache
def turning_gait() -> StoredGait:
    return gaits_of(GaitLibrary.load(solved_library(((0.5, -0.1, 0.3),)) / STORE))[0]


@cache
def pinocchio(dynamics: str = "prismatic") -> PinRobot:
    return PinRobot(config().robot, dynamics)


@cache
def plant() -> Plant:
    return Plant(config().robot)


def table_of(robot: RobotConfig, dynamics: str = "prismatic") -> dict[str, Check]:
    """The checks against a robot."""
    return checks(robot, config().gait.posture, dynamics, config().verification)


@cache
def table(dynamics: str = "prismatic") -> dict[str, Check]:
    return table_of(config().robot, dynamics)


def jobs() -> tuple[list[JobSpec], JobSpec]:
    """The jobs of the small library: those of some gaits each, and the one that collects."""
    code = Code("", "", {})
    solves = [JobSpec("gait", "", code, {"velocity": [*velocity, 0.0]}) for velocity in VELOCITIES]
    source = JobSpec("library", "", code, {}, {"gaits": solves})
    collect = verification_jobs(config(), source)["verification"]
    return list(collect.inputs["gaits"]), collect


@shared.shared
def _solved_with_soles(velocity: tuple[float, float, float]) -> Path:
    out = Path(mkdtemp(prefix="soled-", dir=shared.folder()))
    robot = {f.name: to_dict(soled())[f.name] for f in fields(Mechanism)}
    section = gait_section(config()) | {"robot": robot, "velocity": [*velocity]}
    assert gait_stage.run(section, {}, out, Job(out))["converged"]
    return out


@cache
def gait_with_soles(velocity: tuple[float, float, float] = (0.3, 0.0, 0.0)) -> StoredGait:
    """A gait of the robot of ``tests.robot.soled``."""
    folder, names = _solved_with_soles(velocity), [f.name for f in fields(StoredGait)[2:]]
    arrays = {name: np.load(folder / f"{name}.npy") for name in names}
    return StoredGait(soled().geometry, np.array(velocity), **arrays)


def spoiled(gait: StoredGait, name: str, index: Any, amount: Any) -> StoredGait:
    """A gait with something added to one of its arrays."""
    array = getattr(gait, name).copy()
    array[index] += amount
    return replace(gait, **{name: array})


def failed(
    gait: StoredGait, some: Mapping[str, Check], *names: str, experiment: str = "default"
) -> set[str]:
    """Quantities of some checks, or all, that are beyond the configured bounds."""
    bounds = config(f"experiment={experiment}").verification.bounds
    values = check_gait(gait, {name: some[name] for name in names or some})
    row = pd.DataFrame([dict.fromkeys([*VELOCITY, *QUANTITIES]) | values]).astype(float)
    return set(judge(row, bounds)[0]["failed"][0].split())
