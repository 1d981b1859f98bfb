"""Stages of foot placement: tables of the gaits' zero dynamics for controllers.

``stability_gaits`` linearises some gaits per job, ``foot_placement`` collects their tables.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import partial
from pathlib import Path

import numpy as np

from slider.config.convert import from_dict
from slider.config.hzd import StabilityConfig
from slider.core.arrays import take
from slider.core.casadi_code import Compiled
from slider.core.errors import UserError
from slider.core.job import Inputs, Job, Section, Summary
from slider.hzd.feedback import regulate
from slider.hzd.gains import FootPlacement
from slider.hzd.model import RootedModel
from slider.hzd.plans import StepPlan, plans
from slider.hzd.step import PHASES, ClosedLoop
from slider.hzd.walk import COORDINATES, STATE, find_cycles, linearise
from slider.library.reader import STORE, GaitLibrary
from slider.robot.names import velocity_text

POINTS = "points.npy"
"""x* (G, 2, 22) of the gaits' limit cycles at the sections; NaN where there is none."""
BY_HIP = 1  # the second kind of gains


@dataclass(frozen=True)
class _Placed:
    """A gait's limit cycle and foot placement: x* (2, 22), ξ* (2, S, 4) and K(s) (2, S, 2, 4)."""

    points: np.ndarray
    orbit: np.ndarray
    gains: np.ndarray


def run_gaits(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Limit cycle and foot placement of some gaits; holes are left out.

    Raises:
        UserError: the gaits have the virtual knee's dynamics.
    """
    config = from_dict(StabilityConfig, section["hzd"])
    library = load_library(inputs)
    gaits = indices(library, section["velocities"])
    loop = closed_loop(library, config, job)
    steps = plans(library, gaits, loop.model, config)
    clock = steps[0].clock
    slow = clock | (library.planar_velocities[gaits, 0] <= config.fastest_clock)
    timed = [replace(plan, clock=np.ones_like(clock)) for plan in steps]

    def refuse(kind: str, gait: int, error: Exception) -> None:
        name = velocity_text(library.velocities[gaits[gait]])
        job.progress(f"gait {name}: no foot placement by {kind}: {error}")

    by_hip = _placed(loop, steps, np.flatnonzero(~clock), partial(refuse, "the hip"))
    by_time = _placed(loop, timed, np.flatnonzero(slow), partial(refuse, "time"))
    cycles = {k: placed for k, placed in by_time.items() if clock[k]} | by_hip
    points = np.full((len(gaits), 2, STATE), np.nan)
    for k, placed in cycles.items():
        points[k] = placed.points
    np.save(out / POINTS, points)
    _tables(library, gaits, steps, [by_hip | by_time, by_time | by_hip]).save(out)
    return {"gaits": len(gaits), "stable": len(cycles)}


def _placed(
    loop: ClosedLoop,
    steps: Sequence[StepPlan],
    gaits: np.ndarray,
    refuse: Callable[[int, Exception], None],
) -> dict[int, _Placed]:
    """Place feet of the gaits (n,) that have a limit cycle which foot placement stabilises."""
    if not len(gaits):
        return {}
    steps, result = [take(plan, gaits) for plan in steps], {}
    points, converged = find_cycles(loop, steps)
    walks = linearise(loop, steps, points)
    for k, gait in enumerate(gaits.tolist()):
        try:
            if not converged[k]:
                raise UserError("expected a limit cycle, found none")
            gains = regulate(walks, k, loop.config.feedback).phase_gains
            result[gait] = _Placed(points[:, k], walks.orbit[:, k], gains)
        except (UserError, np.linalg.LinAlgError) as error:
            refuse(gait, error)
    return result


def collect_placement(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Tables of foot placement of all gaits, in the order of the library."""
    library = load_library(inputs)
    parts = [FootPlacement.load(folder) for folder in inputs["gaits"]]
    tables = {
        field.name: np.concatenate([getattr(part, field.name) for part in parts])
        for field in fields(FootPlacement)
        if field.name != "phases"
    }
    order = indices(FootPlacement(phases=PHASES, **tables), library.velocities.tolist())
    ordered = {name: values[order] for name, values in tables.items()}
    FootPlacement(phases=PHASES, **ordered).save(out)
    return {"gaits": len(order)}


def load_library(inputs: Inputs) -> GaitLibrary:
    """Load the library of a stage's inputs.

    Raises:
        UserError: its gaits have the virtual knee's dynamics.
    """
    library = GaitLibrary.load(inputs["library"][0] / STORE)
    if library.dynamics != "prismatic":
        expected = "expected gaits of the prismatic leg (gait.dynamics=prismatic)"
        raise UserError(f"stability: {expected}, found {library.dynamics}")
    return library


def closed_loop(library: GaitLibrary, config: StabilityConfig, job: Job) -> ClosedLoop:
    """The library's robot, its functions compiled where a job can."""
    return ClosedLoop(RootedModel(library.robot, Compiled(job, "robot")), config)


def indices(
    gaits: GaitLibrary | FootPlacement, velocities: Sequence[Sequence[float]]
) -> np.ndarray:
    """Indices of the velocities that the gaits have."""
    places = {tuple(v): k for k, v in enumerate(gaits.velocities.tolist())}
    return np.array([places[tuple(v)] for v in velocities if tuple(v) in places], dtype=int)


def _tables(
    library: GaitLibrary,
    gaits: np.ndarray,
    steps: Sequence[StepPlan],
    kinds: Sequence[Mapping[int, _Placed]],
) -> FootPlacement:
    """Without a limit cycle gains and orbit are zero: the foot is placed where the gait has it.

    ``kinds`` are the gaits by time and by the hip; the orbit is that of the latter.
    """
    shape, width = (len(gaits), 2, len(PHASES)), len(COORDINATES)
    gains = np.zeros((len(gaits), len(kinds), *shape[1:], 2, width))
    orbit = np.zeros((*shape, width))
    for kind, placed in enumerate(kinds):
        for k, gait in placed.items():
            gains[k, kind], orbit[k] = gait.gains, gait.orbit
    gains[:, BY_HIP, ..., COORDINATES.index("com_x")] = 0.0
    return FootPlacement(
        library.velocities[gaits],
        steps[0].clock,
        PHASES,
        gains,
        orbit,
        np.stack([p.placement for p in steps], axis=1),
        np.stack([np.concatenate(list(vars(p.hip).values()), axis=2) for p in steps], axis=1),
    )
