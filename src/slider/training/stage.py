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
from slider.env.vec_env import Task, task_of
from slider.library.reader import STORE
from slider.training.distributed import device_of, launch, rank
from slider.training.trainer import WEIGHTS, Trainer, read_checkpoint


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
    task = task_of(robot, env, train, library, guided)
    start = inputs["start"][0] / WEIGHTS if "start" in inputs else None
    if train.gpus > 1:  # a damaged checkpoint is set aside before several processes look
        read_checkpoint(job.work, job.progress)
    summary, facts = launch(train.gpus, _train, task, start, out, job)
    job.volatile.update(facts)
    return summary


def _train(task: Task, start: Path | None, out: Path, job: Job) -> tuple[Summary, dict[str, Any]]:
    """Train in one process; the first one exports. Return summary and volatile facts."""
    trainer = Trainer(task, job, simulator(task.train))
    if start is not None:
        trainer.start_from(start)
    trainer.run()
    return trainer.export(out) if rank() == 0 else {}, job.volatile


def simulator(train: TrainConfig) -> Callable[..., Any] | None:
    """Constructor of MuJoCo Warp's physics (extra ``gpu``), where a training asks for it.

    Raises:
        UserError: MuJoCo Warp is not installed.
    """
    if train.simulator == "mujoco":
        return None
    warp = import_module(WARP)  # Table 1 does not depend on it
    return partial(warp.WarpPhysics, device=device_of(train.device))
