"""Stages of foot placement: tables of the gaits' zero dynamics for controllers.

``stability_gaits`` linearises some gaits per job, ``foot_placement`` collects their tables.
"""

from collections.abc import Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from slider.config.convert import from_dict
from slider.config.hzd import StabilityConfig
from slider.core.arrays import take
from slider.core.casadi_code import Compiled
from slider.core.errors import UserError
from slider.core.job import Inputs, Job, Section, Summary
from slider.hzd.foot_placement import FootPlacement
from slider.hzd.model import RootedModel
from slider.hzd.plans import StepPlan, plans
from slider.hzd.regulator import regulate
from slider.hzd.step import PHASES, ClosedLoop
from slider.hzd.walk import COORDINATES, find_cycles, linearise
from slider.library.reader import STORE, GaitLibrary
from slider.robot.names import velocity_text

MULTIPLIERS = "multipliers.npy"
"""Multipliers (G, 2, 4), see ``Regulator``; NaN beyond their number, or without a limit cycle."""
BY_HIP = 1  # index of the gains whose phase is the hip


class _Placed(NamedTuple):
    """A gait's limit cycle and foot placement: ξ* (2, S, 4), K(s) (2, S, 2, 4), multipliers."""

    orbit: np.ndarray
    gains: np.ndarray
    multipliers: np.ndarray


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
    slow = clock | (library.velocities[gaits, 0] <= config.fastest_clock)
    timed = [replace(plan, clock=np.ones_like(clock)) for plan in steps]
    names = [velocity_text(library.velocities[gait]) for gait in gaits]
    kinds = []
    for kind, plan, some in (("the hip", steps, ~clock), ("time", timed, slow)):
        placed, refused = _placed(loop, plan, np.flatnonzero(some))
        kinds.append(placed)
        for k, reason in refused.items():
            job.progress(f"gait {names[k]}: no foot placement by {kind}: {reason}")
    by_hip, by_time = kinds
    cycles = {k: placed for k, placed in by_time.items() if clock[k]} | by_hip
    shape, width = (len(gaits), 2, len(PHASES)), len(COORDINATES)
    multipliers = np.full((len(gaits), 2, width), np.nan)
    for k, placed in cycles.items():
        multipliers[k, :, : placed.multipliers.shape[1]] = placed.multipliers
    np.save(out / MULTIPLIERS, multipliers)
    # Without a limit cycle gains and orbit are zero: the foot lands where the gait puts it.
    gains, orbit = np.zeros((len(gaits), 2, *shape[1:], 2, width)), np.zeros((*shape, width))
    for row, placed in enumerate((by_hip | by_time, by_time | by_hip)):
        for k, gait in placed.items():
            gains[k, row], orbit[k] = gait.gains, gait.orbit
    gains[:, BY_HIP, ..., COORDINATES.index("com_x")] = 0.0
    placement = np.stack([plan.placement for plan in steps], axis=1)
    hips = (np.concatenate(list(vars(plan.hip).values()), axis=2) for plan in steps)
    hip, velocities = np.stack(list(hips), axis=1), library.velocities[gaits]
    FootPlacement(velocities, clock, PHASES, gains, orbit, placement, hip).save(out)
    return {"gaits": len(gaits), "stable": len(cycles)}


def _placed(
    loop: ClosedLoop, steps: Sequence[StepPlan], gaits: np.ndarray
) -> tuple[dict[int, _Placed], dict[int, str]]:
    """Limit cycles and foot placement of the gaits (n,), and why the others have none."""
    if not len(gaits):
        return {}, {}
    steps, placed, refused = [take(plan, gaits) for plan in steps], {}, {}
    points, converged = find_cycles(loop, steps)
    walks = linearise(loop, steps, points)
    for k, gait in enumerate(gaits.tolist()):
        try:
            if not converged[k]:
                raise UserError("expected a limit cycle, found none")
            regulator = regulate(walks, k, loop.config.feedback)
            multipliers = regulator.multipliers
            placed[gait] = _Placed(walks.orbit[:, k], regulator.phase_gains, multipliers)
        except (UserError, np.linalg.LinAlgError) as error:
            refused[gait] = str(error)
    return placed, refused


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
    """Closed loop of the library's robot, its functions compiled where that pays."""
    return ClosedLoop(RootedModel(library.robot, Compiled(job, "robot")), config)


def indices(
    gaits: GaitLibrary | FootPlacement, velocities: Sequence[Sequence[float]]
) -> np.ndarray:
    """Index of the gait at each of the velocities that has one."""
    places = {tuple(v): k for k, v in enumerate(gaits.velocities.tolist())}
    return np.array([places[tuple(v)] for v in velocities if tuple(v) in places], dtype=int)
