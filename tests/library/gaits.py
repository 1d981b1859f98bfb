"""Object folders of made-up gaits: smooth functions of the velocity, quick to write."""

import json
from pathlib import Path

import numpy as np

from slider.library.schema import ARRAYS

SAMPLES, HALF = 42, 21
SCALARS = ("velocities", "cost", "max_violation", "iterations")
SHAPES = {
    "samples": (SAMPLES, 26),
    "time": (SAMPLES,),
    "step_time": (2,),
    "base": (SAMPLES, 13),
    "contact": (SAMPLES, 2),
    "coefficients": (2, 10, 9),
    "roll": (2, HALF, 3),
    "knee_positions": (SAMPLES, 10),
    "knee_velocities": (SAMPLES, 10),
    "knee_torques": (SAMPLES, 10),
    "efforts": (SAMPLES, 12),
    "ground_wrench": (SAMPLES, 6),
    "swing_foot": (SAMPLES, 3),
}


def value(name: str, vx: float, vy: float) -> np.ndarray:
    """Linear in velocity, so that linear interpolation is exact."""
    shape = SHAPES[name]
    ramp = np.linspace(0.0, 1.0, int(np.prod(shape))).reshape(shape)
    if name == "step_time":
        return np.full(2, 0.42 - 0.05 * vx)
    array = ramp + vx * (1 + ramp) - 0.5 * vy * ramp
    if name == "base":
        array[:, 3:7] = np.array([1.0, 0.02, 0.0, 0.0])
    return array


def write_gait(folder: Path, vx: float, vy: float, **report: object) -> Path:
    folder.mkdir(parents=True)
    for name in ARRAYS:
        if name not in SCALARS:
            np.save(folder / f"{name}.npy", value(name, vx, vy))
    facts = {"vx": vx, "vy": vy, "status": "Solve_Succeeded", "converged": True}
    facts |= {"iterations": 30, "cost": 1e4 * (1 + vx), "max_violation": 1e-9}
    facts |= {"residuals": {"impact": 1e-9, "torso": 0.0}}
    (folder / "report.json").write_text(json.dumps(facts | report))
    return folder
