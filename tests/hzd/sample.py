"""A library of two real gaits, one with the clock and one with the hip for a phase."""

from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from pipeline.stages.gaits import library_job, stability_jobs
from slider.config.hzd import HzdConfig
from slider.core.arrays import take
from slider.core.job import Job
from slider.hzd import stage
from slider.hzd.model import RootedModel
from slider.hzd.plans import StepPlan, plans
from slider.hzd.step import ClosedLoop
from slider.hzd.walk import (
    STATE,
    ZeroDynamics,
    differences,
    find_cycles,
    linearise,
    middle,
    observed,
    with_moves,
)
from slider.library.reader import STORE, GaitLibrary
from tests import shared
from tests.gait.gaits import config
from tests.library.solved import solved_library

VELOCITIES = [(0.2, 0.0, 0.0), (0.6, 0.1, 0.0)]
CLOCK, HIP = range(2)


def folder() -> Path:
    """Object folder of the library."""
    return solved_library(tuple(VELOCITIES))


@cache
def library() -> GaitLibrary:
    return GaitLibrary.load(folder() / STORE)


def settings() -> HzdConfig:
    return config().hzd


@cache
def loop() -> ClosedLoop:
    return ClosedLoop(RootedModel(library().robot), settings())


@cache
def steps() -> tuple[StepPlan, StepPlan]:
    return plans(library(), np.arange(len(library())), loop().model, settings())


def one(gait: int) -> list[StepPlan]:
    """Both steps of a gait alone."""
    return [take(plan, np.array([gait])) for plan in steps()]


@shared.shared
def points() -> np.ndarray:
    """x* (2, G, 22) of the limit cycles."""
    cycles = [find_cycles(loop(), one(gait)) for gait in range(len(library()))]
    assert all(found.all() for _, found in cycles)
    return np.concatenate([x for x, _ in cycles], axis=1)


@shared.shared
def zero(gait: int) -> ZeroDynamics:
    return linearise(loop(), one(gait), points()[:, [gait]])


@shared.shared
def whole(gait: int) -> SimpleNamespace:
    """Return map of a gait in all 22 states: DP (2, 22, 22), ∂P/∂b (2, 22, 2) and Z (2, r, 22).

    Derived apart from the zero dynamics' directions; Z x is ξ on them with the same future.
    """
    size, slopes = settings().linearisation.difference, []
    for plan, x in zip(one(gait), points()[:, [gait]], strict=True):

        def observe(z: np.ndarray, rows: np.ndarray, plan: StepPlan = plan) -> np.ndarray:
            return observed(loop(), loop().step(take(plan, rows), z[:, :STATE], z[:, STATE:]))

        slopes.append(differences(observe, with_moves(x), size)[1][0])
    landed, seen = np.split(np.stack(slopes), [STATE], axis=1)
    now = zero(gait).by_state[:, 0, middle(loop())]
    future = seen.reshape(2, -1, 4, STATE + 2)[:, middle(loop()), : now.shape[1], :STATE]
    return SimpleNamespace(
        derivatives=landed[..., :STATE],
        placements=landed[..., STATE:],
        projection=np.linalg.solve(now, future),
    )


HOLE = (0.9, 0.0, 0.0)


def place(
    out: Path, *velocities: tuple[float, float, float], store: Path | None = None, **changes: Any
) -> list[str]:
    """What a job of foot placement says; ``changes`` are those of ``hzd``."""
    (spec, *_) = stability_jobs(config(), library_job(config()))["foot_placement"].inputs["gaits"]
    section = {**spec.section, "velocities": [list(v) for v in velocities]}
    section["hzd"] = spec.section["hzd"] | changes
    said: list[str] = []
    inputs = {"library": [store or folder()]}
    stage.run_gaits(section, inputs, out, Job(out, progress=said.append))
    return said


@shared.shared
def chunk() -> Path:
    """Object folder of the foot placement of both gaits, the faster one first, and of a hole."""
    out = shared.new_folder()
    assert place(out, *VELOCITIES[::-1], HOLE) == []
    return out


@shared.shared
def placement_folder() -> Path:
    """Object folder of the library's foot placement."""
    out = shared.new_folder()
    stage.collect_placement({}, {"library": [folder()], "gaits": [chunk()]}, out, Job(out))
    return out
