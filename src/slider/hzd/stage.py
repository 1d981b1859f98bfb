"""Stages of the gaits' stability.

``stability_gaits`` linearises some gaits per job. ``foot_placement`` collects the tables that
controllers take, ``stability`` the numbers that people read. ``basin`` is about one gait.
"""

import json
from collections.abc import Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from slider.config.convert import from_dict
from slider.config.hzd import BasinConfig, ImpactGrid, StabilityConfig
from slider.core.errors import UserError
from slider.core.job import Inputs, Job, Section, Summary
from slider.hzd.basin import Placement, axes, portrait, steps_until_return
from slider.hzd.gains import FootPlacement
from slider.hzd.invariance import Invariance, invariance, perturbed
from slider.hzd.model import RootedModel
from slider.hzd.plans import plans
from slider.hzd.poincare import multipliers
from slider.hzd.step import PHASES, ClosedLoop, StepPlan
from slider.hzd.summary import per_step, write_csv, write_markdown
from slider.hzd.walk import COORDINATES, Linearisation, Walk, linearise, walk
from slider.library.reader import STORE, GaitLibrary
from slider.robot.names import COMMAND

RECORDS = "gaits.json"
BY_HIP = 1  # the second kind of gains
CSV, MARKDOWN = "stability.csv", "stability.md"
_OF_WALK = (
    *("spectral_radius", "eigenvalues", "closed_eigenvalues", "closed_spectral_radius"),
    *("gain_position", "gain_lateral", "gain_forward", "difference"),
)
_PUSH = 0.1  # a portrait's start: share of the greatest perturbation of the roll rate


def run_gaits(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Limit cycle, return map, foot placement and invariance of some gaits; holes are left out.

    Raises:
        UserError: the gaits have the virtual knee's dynamics.
    """
    config = from_dict(StabilityConfig, section["hzd"])
    library = _library(inputs)
    gaits = _indices(library, section["commands"])
    loop = ClosedLoop(RootedModel(library.robot), config)
    steps = plans(library, gaits, loop.model, config)
    found, walks = _walks(loop, steps, np.arange(len(gaits)))
    job.progress(f"{found.found.sum()} of {len(gaits)} limit cycles")
    kept = invariance(loop, steps, found.points, config.impacts)
    records = [_record(library, gait, steps, k, walks[k], kept) for k, gait in enumerate(gaits)]
    (out / RECORDS).write_text(json.dumps(records, indent=1, allow_nan=False) + "\n")
    slow = library.velocities[gaits, 0] <= config.fastest_clock
    by_time = _by_time(loop, steps, walks, np.flatnonzero(~steps[0].clock & slow))
    _placement(library, gaits, steps, [by_time, walks]).save(out)
    return {"gaits": len(gaits), "limit_cycles": int(found.found.sum())}


def _by_time(
    loop: ClosedLoop,
    steps: Sequence[StepPlan],
    walks: Sequence[Walk | None],
    by_hip: np.ndarray,
) -> list[Walk | None]:
    """The same walks where the steps of some of them, ``by_hip`` (n,), go by time."""
    timed = [replace(plan, clock=np.ones_like(plan.clock)) for plan in steps]
    found = list(walks)
    others = _walks(loop, timed, by_hip)[1] if len(by_hip) else []
    for k, other in zip(by_hip, others, strict=True):
        found[k] = other
    return found


def _walks(
    loop: ClosedLoop, steps: Sequence[StepPlan], gaits: np.ndarray
) -> tuple[Linearisation, list[Walk | None]]:
    """Of some of the gaits."""
    own = [plan.of(gaits) for plan in steps]
    found = linearise(loop, own, loop.config)
    return found, [_walk(loop, own, found, k, loop.config) for k in range(len(gaits))]


def collect_placement(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Tables of foot placement of all gaits, in the order of the library."""
    library = _library(inputs)
    parts = [FootPlacement.load(folder) for folder in inputs["gaits"]]
    whole = {
        field.name: np.concatenate([getattr(part, field.name) for part in parts])
        for field in fields(FootPlacement)
        if field.name != "phases"
    }
    order = _indices(FootPlacement(phases=PHASES, **whole), library.commands.tolist())
    ordered = {name: values[order] for name, values in whole.items()}
    FootPlacement(phases=parts[0].phases, **ordered).save(out)
    return {"gaits": len(order)}


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Table of all gaits as CSV, and for people."""
    rows = [row for folder in inputs["gaits"] for row in json.loads((folder / RECORDS).read_text())]
    rows.sort(key=lambda row: [row[name] for name in COMMAND])
    write_csv(out / CSV, rows)
    write_markdown(out / MARKDOWN, rows)
    job.tracker.log_file(out / CSV)
    radii = [row["closed_spectral_radius"] for row in rows]
    known = [radius for radius in radii if radius is not None]
    return {"gaits": len(rows), "stable": sum(radius < 1.0 for radius in known)}


def run_basin(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Basin of attraction of one gait with and without foot placement, and a walk of each.

    Raises:
        UserError: the library lacks the gait, or no foot placement stabilises it.
    """
    config = from_dict(StabilityConfig, section["hzd"])
    basin = from_dict(BasinConfig, section["basin"])
    library = _library(inputs)
    gait = np.array([library.find(*section["command"])])
    loop = ClosedLoop(RootedModel(library.robot), config)
    steps = plans(library, gait, loop.model, config)
    found = walk(loop, steps, linearise(loop, steps, config), 0, config)
    arrays = {name: np.array(values) for name, values in vars(axes(basin)).items()}
    arrays["command"] = library.commands[gait[0]]
    push = ImpactGrid([0.0], [_PUSH * basin.roll_rate.upper])
    start = perturbed(loop, found.points[:1], push)[1][0]
    cases = {"without": None, "with": Placement(found, config.feedback.reach)}
    for name, placement in cases.items():
        job.progress(f"basin {name} foot placement")
        arrays[name] = steps_until_return(loop, steps, found, basin, placement)
        arrays[f"walk_{name}"] = portrait(loop, steps, found, start, basin.steps, placement)
    arrays["cycle"] = portrait(loop, steps, found, found.points[0], 2, None)
    for name, array in arrays.items():
        np.save(out / f"{name}.npy", array)
    return {name: int((arrays[name] >= 0).sum()) for name in cases}


def _library(inputs: Inputs) -> GaitLibrary:
    library = GaitLibrary.load(inputs["library"][0] / STORE)
    if library.dynamics != "prismatic":
        expected = "expected gaits of the prismatic leg (gait.dynamics=prismatic)"
        raise UserError(f"stability: {expected}, found {library.dynamics}")
    return library


def _indices(gaits: GaitLibrary | FootPlacement, commands: Sequence[Sequence[float]]) -> np.ndarray:
    """Places of the commands that there are."""
    places = {tuple(v): k for k, v in enumerate(gaits.commands.tolist())}
    return np.array([places[tuple(v)] for v in commands if tuple(v) in places], dtype=int)


def _walk(
    loop: ClosedLoop,
    steps: Sequence[StepPlan],
    found: Linearisation,
    gait: int,
    config: StabilityConfig,
) -> Walk | None:
    """None where there is no limit cycle, or none that foot placement stabilises."""
    try:
        return walk(loop, steps, found, gait, config) if found.found[gait] else None
    except (UserError, np.linalg.LinAlgError):
        return None


def _record(
    library: GaitLibrary,
    gait: int,
    steps: Sequence[StepPlan],
    place: int,
    found: Walk | None,
    kept: Invariance,
) -> dict[str, Any]:
    """Values of ``slider.hzd.summary.QUANTITIES``; None where there is no limit cycle."""
    share = [p.hip_share[place] for p in steps]
    values = library.arrays["decoupling"][gait]
    record = {
        **dict(zip(COMMAND, map(float, library.commands[gait]), strict=True)),
        "phase": "time" if steps[0].clock[place] else "hip",
        "hip_share": None if steps[0].clock[place] else float(min(share)),
        "decoupling": float(values[:, 0].min()),
        "condition": float(values[:, 1].max()),
    }
    measured = {
        f"invariance_{n}": getattr(kept, n) for n in ("orbit", "impact", "free", "anchored")
    }
    for name, each in (measured | {"settle_angle": kept.settle}).items():
        record[name] = float(each[place]) if found and np.isfinite(each[place]) else None
    return record | _stability(found)


def _stability(found: Walk | None) -> dict[str, Any]:
    if found is None:
        return dict.fromkeys(_OF_WALK)
    gains = -found.phase_gains[0, 0]
    open_, closed = (
        per_step(np.linalg.eigvals(maps[1] @ maps[0])) for maps in (found.maps, found.closed)
    )
    return {
        "spectral_radius": per_step(multipliers(found.derivatives))[0],
        "eigenvalues": open_,
        "closed_eigenvalues": closed,
        "closed_spectral_radius": per_step(multipliers(found.closed_derivatives))[0],
        "gain_position": float(gains[1, 0]),
        "gain_lateral": float(gains[1, 1]),
        "gain_forward": float(gains[0, 2]),
        "difference": found.error,
    }


def _placement(
    library: GaitLibrary,
    gaits: np.ndarray,
    steps: Sequence[StepPlan],
    kinds: Sequence[Sequence[Walk | None]],
) -> FootPlacement:
    """Without a limit cycle gains and orbit are zero: the foot is placed where the gait has it.

    ``kinds`` are the walks by time and by the hip; the orbit is that of the latter.
    """
    shape, width = (len(gaits), 2, len(PHASES)), len(COORDINATES)
    gains = np.zeros((len(gaits), len(kinds), *shape[1:], 2, width))
    orbit = np.zeros((*shape, width))
    for kind, walks in enumerate(kinds):
        for k, found in enumerate(walks):
            if found is not None:
                gains[k, kind], orbit[k] = found.phase_gains, found.orbit
    gains[:, BY_HIP, ..., COORDINATES.index("com_x")] = 0.0
    return FootPlacement(
        library.commands[gaits],
        steps[0].clock,
        PHASES,
        gains,
        orbit,
        np.stack([p.placement for p in steps], axis=1),
        np.stack([np.concatenate(p.hip.orders, axis=2) for p in steps], axis=1),
    )
