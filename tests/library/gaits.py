"""Object folders of made-up gaits: smooth functions of the velocity, quick to write."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from slider.config.convert import to_dict
from slider.core.job import Job
from slider.library.reader import ARRAYS, GaitLibrary, labels
from slider.library.stage import run
from tests import shared
from tests.config.composed import composed

SAMPLES, HALF = 42, 21
SCALARS = ("velocities", "cost", "max_violation", "iterations", "residuals")
MECHANISM = ("geometry", "links", "virtual_knee", "joints", "drives", "capstan")
ROBOT = {name: to_dict(composed().robot)[name] for name in MECHANISM}
Velocities = Sequence[tuple[float, ...]]  # vx, vy [m/s] and, if it is not zero, yaw rate [rad/s]
SIZES = {"sample": SAMPLES, "node": HALF, "coefficient": 9}
SIZES |= {axis: len(names) for axis, names in labels(composed().robot.geometry).items()}
SHAPES = {
    name: tuple(map(SIZES.get, array.axes)) for name, array in ARRAYS.items() if name not in SCALARS
}


def value(name: str, vx: float, vy: float, yaw_rate: float = 0.0) -> np.ndarray:
    """Linear in the velocity, so that linear interpolation is exact."""
    shape = SHAPES[name]
    ramp = np.linspace(0.0, 1.0, int(np.prod(shape))).reshape(shape)
    if name == "step_time":
        return np.full(2, 0.42 - 0.05 * vx)
    array = ramp + vx * (1 + ramp) - 0.5 * vy * ramp + 0.2 * yaw_rate * (1 - ramp)
    if name == "base":
        array[:, 3:7] = np.array([1.0, 0.02, 0.0, 0.0])
    return array


def write_gait(folder: Path, vx: float, vy: float, yaw_rate: float = 0.0, **report: object) -> Path:
    folder.mkdir(parents=True)
    for name in SHAPES:
        np.save(folder / f"{name}.npy", value(name, vx, vy, yaw_rate))
    facts = {"vx": vx, "vy": vy, "yaw_rate": yaw_rate, "cost": 1e4 * (1 + vx)}
    facts |= {"status": "Solve_Succeeded", "converged": True, "iterations": 30}
    facts |= {"cost_unit": "N² m²/s", "max_violation": 1e-9}
    facts |= {"residuals": {"impact": 1e-9, "torso": 0.0}}
    facts |= report
    facts["worst"] = {name: f"{value:g}, at most 0" for name, value in facts["residuals"].items()}
    (folder / "report.json").write_text(json.dumps(facts))
    return folder


def section(allow_holes: bool = False) -> dict[str, Any]:
    """Section of the stage ``library``."""
    return {
        "library": {"allow_holes": allow_holes, "max_violation": 1e-6},
        "robot": ROBOT,
        "dynamics": "prismatic",
        "cost": "paper",
        "kinematic_map": "exact",
    }


def write_store(folder: Path, velocities: Velocities, holes: Velocities = ()) -> Path:
    """A library of made-up gaits, with holes; the path of its ``library.zarr``."""
    gaits = [write_gait(folder / f"gait{i}", *v) for i, v in enumerate(velocities)]
    failed = {"converged": False, "status": "Infeasible_Problem_Detected", "max_violation": 0.3}
    failed |= {"residuals": {"impact": 1e-3, "torso": 0.3}}
    gaits += [write_gait(folder / f"hole{i}", *v, **failed) for i, v in enumerate(holes)]
    out = folder / "out"
    run(section(bool(holes)), {"gaits": gaits}, out, Job(folder))
    return out / "library.zarr"


def library(folder: Path, velocities: Velocities, holes: Velocities = ()) -> GaitLibrary:
    return GaitLibrary.load(write_store(folder, velocities, holes))


@shared.shared
def straight() -> Path:
    """Object folder of such a library straight ahead: do not change it."""
    return write_store(shared.new_folder(), [(0.0, 0.0), (0.5, 0.0), (1.0, 0.0)]).parent
