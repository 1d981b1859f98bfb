"""The stages ``standing`` and ``walking``."""

from collections.abc import Callable
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

from slider.config.convert import from_dict
from slider.config.env import EnvConfig
from slider.config.robot import RobotConfig
from slider.config.train import WARP, TrainConfig
from slider.core.job import Inputs, Job, Section, Summary
from slider.env.vec_env import task_of
from slider.library.reader import STORE
from slider.training.trainer import WEIGHTS, Trainer


def run_standing(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Pre-train a policy that stands; it is not guided by the library."""
    return _run(section, inputs, out, job, guided=False)


def run_walking(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Train walking, from the weights of another training and with the library, where given."""
    return _run(section, inputs, out, job, guided=True)


def _run(section: Section, inputs: Inputs, out: Path, job: Job, guided: bool) -> Summary:
    """Train, from the weights of another training where given, and export the best policy."""
    robot, env = from_dict(RobotConfig, section["robot"]), from_dict(EnvConfig, section["env"])
    train = from_dict(TrainConfig, section["train"])
    library = inputs["library"][0] / STORE if "library" in inputs else None
    trainer = Trainer(task_of(robot, env, train, library, guided), job, simulator(train))
    if "start" in inputs:
        trainer.start_from(inputs["start"][0] / WEIGHTS)
    trainer.run()
    return trainer.export(out)


def simulator(train: TrainConfig) -> Callable[..., Any] | None:
    """Constructor of MuJoCo Warp's physics (extra ``gpu``), where a training asks for it.

    Raises:
        UserError: MuJoCo Warp is not installed.
    """
    if train.simulator == "mujoco":
        return None
    warp = import_module(WARP)  # Table 1 does not depend on it
    return partial(warp.WarpPhysics, device=train.device)
