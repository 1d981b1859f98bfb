"""A small library of real gaits, solved once per test session, and ways to spoil it."""

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from pipeline.stages.gaits import verification_jobs
from slider.artefacts.plan import JobSpec
from slider.artefacts.recipe import Code
from slider.config.schema import Config
from slider.library.reader import STORE, GaitLibrary
from slider.verification.pin_robot import PinRobot
from slider.verification.plant import Plant
from slider.verification.stage import Check, checks
from slider.verification.stored import StoredGait, gaits_of
from tests.config.composed import composed
from tests.library.solved import solved_library

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
def turning_gaits() -> list[StoredGait]:
    """Two gaits that turn, reflections of each other."""
    folder = solved_library(((0.5, 0.1, -0.3), (0.5, -0.1, 0.3)))
    return gaits_of(GaitLibrary.load(folder / STORE))


@cache
def pinocchio(dynamics: str = "prismatic") -> PinRobot:
    return PinRobot(config().robot, dynamics)


@cache
def plant() -> Plant:
    return Plant(config().robot)


@cache
def table(dynamics: str = "prismatic") -> dict[str, Check]:
    c = config()
    return checks(c.robot, c.gait.posture, dynamics, c.verification)


def jobs() -> tuple[list[JobSpec], JobSpec]:
    """The jobs of the small library: those of some gaits each, and the one that collects."""
    code = Code("", "", {})
    solves = [JobSpec("gait", "", code, {"velocity": [*velocity, 0.0]}) for velocity in VELOCITIES]
    source = JobSpec("library", "", code, {}, {"gaits": solves})
    collect = verification_jobs(config(), source)["verification"]
    return list(collect.inputs["gaits"]), collect


def spoiled(gait: StoredGait, name: str, index: Any, amount: Any) -> StoredGait:
    """A gait with something added to one of its arrays."""
    array = getattr(gait, name).copy()
    array[index] += amount
    return replace(gait, **{name: array})
