"""Stages of reports on the gaits' stability; no controller waits for them.

``return_maps`` has numbers of some gaits, ``stability`` their table. ``basin`` is about one gait.
"""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from slider.config.convert import from_dict
from slider.config.hzd import BasinConfig, ImpactGrid, StabilityConfig
from slider.core.arrays import take
from slider.core.errors import UserError
from slider.core.job import Inputs, Job, Section, Summary
from slider.hzd.plans import StepPlan, plans
from slider.hzd.return_map import (
    ReturnMap,
    axes,
    invariance,
    perturbed,
    portrait,
    return_maps,
    steps_until_return,
)
from slider.hzd.stage import POINTS, closed_loop, indices, load_library
from slider.hzd.summary import CSV, MARKDOWN, per_step, write_csv, write_markdown
from slider.hzd.walk import find_cycles, multipliers
from slider.library.reader import GaitLibrary
from slider.robot.names import VELOCITY, velocity_text

RECORDS = "gaits.json"
_OF_WALK = (
    *("spectral_radius", "eigenvalues", "closed_eigenvalues", "closed_spectral_radius"),
    *("gain_position", "gain_lateral", "gain_forward", "difference"),
)
_PUSH = 0.1  # a portrait's start: share of the greatest perturbation of the roll rate


def run_maps(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Return map and invariance of the gaits of a job of ``stability_gaits``."""
    config = from_dict(StabilityConfig, section["hzd"])
    library = load_library(inputs)
    gaits = indices(library, section["velocities"])
    loop = closed_loop(library, config, job)
    steps = plans(library, gaits, loop.model, config)
    points = np.load(inputs["gaits"][0] / POINTS).swapaxes(0, 1)
    walks: dict[int, ReturnMap] = {}
    periodic, clock = np.isfinite(points).all(axis=(0, 2)), steps[0].clock
    for kind in (np.flatnonzero(periodic & clock), np.flatnonzero(periodic & ~clock)):
        if len(kind):
            maps = return_maps(loop, [take(plan, kind) for plan in steps], points[:, kind])
            walks |= dict(zip(kind.tolist(), maps, strict=True))
    job.progress(f"{len(walks)} of {len(gaits)} return maps")
    residuals = invariance(loop, steps, points, from_dict(ImpactGrid, section["impacts"]))
    records = [
        _record(library, gait, steps, k, walks.get(k), residuals) for k, gait in enumerate(gaits)
    ]
    (out / RECORDS).write_text(
        json.dumps(records, indent=1, allow_nan=False) + "\n", encoding="utf-8"
    )
    return {"gaits": len(gaits), "limit_cycles": len(walks)}


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Table of all gaits as CSV, and for people."""
    records = [(folder / RECORDS).read_text(encoding="utf-8") for folder in inputs["gaits"]]
    rows = [row for text in records for row in json.loads(text)]
    rows.sort(key=lambda row: [row[name] for name in VELOCITY])
    write_csv(out / CSV, rows)
    write_markdown(out / MARKDOWN, rows)
    radii = [row["closed_spectral_radius"] for row in rows]
    return {"gaits": len(rows), "stable": sum(r is not None and r < 1.0 for r in radii)}


def run_basin(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Basin of attraction of one gait with and without foot placement, and a walk of each.

    Raises:
        UserError: the library lacks the gait, or no foot placement stabilises it.
    """
    config = from_dict(StabilityConfig, section["hzd"])
    basin = from_dict(BasinConfig, section["basin"])
    library = load_library(inputs)
    gait = np.array([library.find(*section["velocity"])])
    loop = closed_loop(library, config, job)
    steps = plans(library, gait, loop.model, config)
    name = velocity_text(section["velocity"])
    points, converged = find_cycles(loop, steps)
    if not converged[0]:
        raise UserError(f"gait {name}: expected a limit cycle, found none")
    try:
        cycle = return_maps(loop, steps, points)[0]
    except UserError as error:
        raise UserError(f"gait {name}: {error}") from None
    arrays = {name: np.array(values) for name, values in vars(axes(basin)).items()}
    arrays["velocity"] = library.velocities[gait[0]]
    push = ImpactGrid([0.0], [_PUSH * basin.roll_rate.upper])
    start = perturbed(loop, cycle.points[:1], push)[1][0]
    cases = {"without": 0.0, "with": config.feedback.reach}
    for case, reach in cases.items():
        job.progress(f"basin {case} foot placement")
        arrays[case] = steps_until_return(loop, steps, cycle, basin, reach)
        arrays[f"walk_{case}"] = portrait(loop, steps, cycle, start, basin.steps, reach)
    arrays["cycle"] = portrait(loop, steps, cycle, cycle.points[0], 2, 0.0)
    for name, array in arrays.items():
        np.save(out / f"{name}.npy", array)
    return {case: int((arrays[case] >= 0).sum()) for case in cases}


def _record(
    library: GaitLibrary,
    gait: int,
    steps: Sequence[StepPlan],
    place: int,
    walk: ReturnMap | None,
    residuals: Mapping[str, np.ndarray],
) -> dict[str, Any]:
    """Values of ``slider.hzd.summary.QUANTITIES``; None where there is no limit cycle."""
    clock, values = steps[0].clock[place], library.arrays["decoupling"][gait]
    record = {
        **dict(zip(VELOCITY, map(float, library.velocities[gait]), strict=True)),
        "phase": "time" if clock else "hip",
        "hip_share": None if clock else float(min(plan.hip_share[place] for plan in steps)),
        "decoupling": float(values[:, 0].min()),
        "condition": float(values[:, 1].max()),
    }
    for name, each in residuals.items():
        record[name] = float(each[place]) if walk and np.isfinite(each[place]) else None
    if walk is None:
        return record | dict.fromkeys(_OF_WALK)
    gains = -walk.regulator.phase_gains[0, 0]
    open_, closed = (per_step(multipliers(maps)) for maps in (walk.maps, walk.closed))
    values = (
        per_step(multipliers(walk.derivatives))[0],
        open_,
        closed,
        per_step(multipliers(walk.closed_derivatives))[0],
        *(float(gains[place]) for place in ((1, 0), (1, 1), (0, 2))),
        walk.error,
    )
    return record | dict(zip(_OF_WALK, values, strict=True))
