"""Stages of reports on the gaits' stability; no controller waits for them.

``return_maps`` has numbers of some gaits, ``stability`` their table. ``basin`` is about one gait.
"""

import json
from collections.abc import Sequence
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
    Invariance,
    Placement,
    ReturnMap,
    axes,
    invariance,
    perturbed,
    portrait,
    return_maps,
    steps_until_return,
)
from slider.hzd.stage import POINTS, closed_loop, indices, load_library
from slider.hzd.step import ClosedLoop
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
    walks = _walks(loop, steps, points)
    job.progress(f"{len(walks)} of {len(gaits)} return maps")
    residuals = invariance(loop, steps, points, from_dict(ImpactGrid, section["impacts"]))
    records = [
        _record(library, gait, steps, k, walks.get(k), residuals) for k, gait in enumerate(gaits)
    ]
    (out / RECORDS).write_text(
        json.dumps(records, indent=1, allow_nan=False) + "\n", encoding="utf-8"
    )
    return {"gaits": len(gaits), "limit_cycles": len(walks)}


def _walks(loop: ClosedLoop, steps: Sequence[StepPlan], points: np.ndarray) -> dict[int, ReturnMap]:
    """Return maps by gait, of those with limit cycles through ``points`` (2, n, 22)."""
    walks, periodic, clock = {}, np.isfinite(points).all(axis=(0, 2)), steps[0].clock
    for gaits in (np.flatnonzero(periodic & clock), np.flatnonzero(periodic & ~clock)):
        if len(gaits):
            maps = return_maps(loop, [take(plan, gaits) for plan in steps], points[:, gaits])
            walks |= dict(zip(gaits.tolist(), maps, strict=True))
    return walks


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Table of all gaits as CSV, and for people."""
    records = [(folder / RECORDS).read_text(encoding="utf-8") for folder in inputs["gaits"]]
    rows = [row for text in records for row in json.loads(text)]
    rows.sort(key=lambda row: [row[name] for name in VELOCITY])
    write_csv(out / CSV, rows)
    write_markdown(out / MARKDOWN, rows)
    job.tracker.log_file(out / CSV)
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
    cycle = _walk(loop, steps, velocity_text(section["velocity"]))
    arrays = {name: np.array(values) for name, values in vars(axes(basin)).items()}
    arrays["velocity"] = library.velocities[gait[0]]
    push = ImpactGrid([0.0], [_PUSH * basin.roll_rate.upper])
    start = perturbed(loop, cycle.points[:1], push)[1][0]
    cases = {"without": None, "with": Placement(cycle, config.feedback.reach)}
    for name, placement in cases.items():
        job.progress(f"basin {name} foot placement")
        arrays[name] = steps_until_return(loop, steps, cycle, basin, placement)
        arrays[f"walk_{name}"] = portrait(loop, steps, cycle, start, basin.steps, placement)
    arrays["cycle"] = portrait(loop, steps, cycle, cycle.points[0], 2, None)
    for name, array in arrays.items():
        np.save(out / f"{name}.npy", array)
    return {name: int((arrays[name] >= 0).sum()) for name in cases}


def _walk(loop: ClosedLoop, steps: Sequence[StepPlan], name: str) -> ReturnMap:
    points, converged = find_cycles(loop, steps)
    if not converged[0]:
        raise UserError(f"gait {name}: expected a limit cycle, found none")
    try:
        return return_maps(loop, steps, points)[0]
    except UserError as error:
        raise UserError(f"gait {name}: {error}") from None


def _record(
    library: GaitLibrary,
    gait: int,
    steps: Sequence[StepPlan],
    place: int,
    walk: ReturnMap | None,
    residuals: Invariance,
) -> dict[str, Any]:
    """Values of ``slider.hzd.summary.QUANTITIES``; None where there is no limit cycle."""
    share = [p.hip_share[place] for p in steps]
    values = library.arrays["decoupling"][gait]
    record = {
        **dict(zip(VELOCITY, map(float, library.velocities[gait]), strict=True)),
        "phase": "time" if steps[0].clock[place] else "hip",
        "hip_share": None if steps[0].clock[place] else float(min(share)),
        "decoupling": float(values[:, 0].min()),
        "condition": float(values[:, 1].max()),
    }
    measured = {
        f"invariance_{n}": getattr(residuals, n) for n in ("orbit", "impact", "free", "anchored")
    }
    for name, each in (measured | {"settle_angle": residuals.settle}).items():
        record[name] = float(each[place]) if walk and np.isfinite(each[place]) else None
    return record | _stability(walk)


def _stability(walk: ReturnMap | None) -> dict[str, Any]:
    if walk is None:
        return dict.fromkeys(_OF_WALK)
    gains = -walk.regulator.phase_gains[0, 0]
    open_, closed = (
        per_step(np.linalg.eigvals(maps[1] @ maps[0])) for maps in (walk.maps, walk.closed)
    )
    return {
        "spectral_radius": per_step(multipliers(walk.derivatives))[0],
        "eigenvalues": open_,
        "closed_eigenvalues": closed,
        "closed_spectral_radius": per_step(multipliers(walk.closed_derivatives))[0],
        "gain_position": float(gains[1, 0]),
        "gain_lateral": float(gains[1, 1]),
        "gain_forward": float(gains[0, 2]),
        "difference": walk.error,
    }
