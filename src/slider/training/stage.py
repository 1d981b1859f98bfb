"""The stages ``standing`` and ``walking``."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from slider.config.convert import from_dict
from slider.config.env import EnvConfig
from slider.config.robot import RobotConfig
from slider.config.train import TrainConfig
from slider.core.job import Inputs, Job, Section, Summary
from slider.env.task import Task, task_of
from slider.env.underlying import Underlying, build_physics
from slider.library.reader import STORE
from slider.training import checkpoint
from slider.training.distributed import launch, rank
from slider.training.trainer import WEIGHTS, Trainer

Simulate = Callable[..., Any]


def run_standing(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Pre-train a policy that stands; it is not guided by the library."""
    return train(task(section, inputs, guided=False), inputs, out, job)


def run_walking(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Train walking, from the weights of another training and with the library, where given."""
    return train(task(section, inputs, guided=True), inputs, out, job)


def train(
    task: Task, inputs: Inputs, out: Path, job: Job, simulate: Simulate = build_physics
) -> Summary:
    """Train, from the weights of another training where given, and export the best policy."""
    start = inputs["start"][0] / WEIGHTS if "start" in inputs else None
    if task.train.gpus > 1:  # a damaged checkpoint is set aside before several processes look
        checkpoint.read(job.work, job.progress)
    summary, facts = launch(task.train.gpus, _train, task, start, out, job, simulate)
    job.volatile.update(facts)
    return summary


def _train(
    task: Task, start: Path | None, out: Path, job: Job, simulate: Simulate
) -> tuple[Summary, dict[str, Any]]:
    """The part of one process; its facts, of which the first process writes files."""
    trainer = Trainer(task, job, simulate)
    if start is not None:
        trainer.start_from(start)
    trainer.run()
    return trainer.export(out) if rank() == 0 else {}, job.volatile


def task(
    section: Section, inputs: Inputs, guided: bool, underlying: Underlying | None = None
) -> Task:
    """The task of a stage's section and inputs."""
    robot, env = from_dict(RobotConfig, section["robot"]), from_dict(EnvConfig, section["env"])
    settings = from_dict(TrainConfig, section["train"])
    library = inputs["library"][0] / STORE if "library" in inputs else None
    return task_of(robot, env, settings, library, guided, underlying)
