"""The stages ``standing`` and ``walking`` with MuJoCo Warp.

They are apart from the others so that no other recipe holds the versions of the extra ``gpu``.
"""

from functools import partial
from pathlib import Path
from typing import Any

from slider.core.job import Inputs, Job, Section, Summary
from slider.env.warp.physics import WarpPhysics
from slider.training.distributed import device_of
from slider.training.stage import task, train


def run_standing(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Pre-train a policy that stands."""
    return _train(section, inputs, out, job, guided=False)


def run_walking(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Train walking."""
    return _train(section, inputs, out, job, guided=True)


def _train(section: Section, inputs: Inputs, out: Path, job: Job, guided: bool) -> Summary:
    simulate = partial(build_physics, section["train"]["device"])
    return train(task(section, inputs, guided), inputs, out, job, simulate)


def build_physics(
    kind: str, robot: Any, config: Any, count: int, *_: Any, **settings: Any
) -> WarpPhysics:
    """Robots on the device of this process; ``settings`` has the disturbance."""
    return WarpPhysics(robot, config, count, device_of(kind), settings["disturbance"])
