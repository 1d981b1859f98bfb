"""The stages ``standing`` and ``walking``."""

from pathlib import Path

from slider.config.convert import from_dict
from slider.config.env import EnvConfig
from slider.config.robot import RobotConfig
from slider.config.train import TrainConfig
from slider.core.job import Inputs, Job, Section, Summary
from slider.env.task import Task, task_of
from slider.env.underlying import Underlying
from slider.library.reader import STORE
from slider.training.trainer import WEIGHTS, Trainer


def run_standing(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Pre-train a policy that stands; it is not guided by the library."""
    return train(task(section, inputs, guided=False), inputs, out, job)


def run_walking(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Train walking, from the weights of another training and with the library, where given."""
    return train(task(section, inputs, guided=True), inputs, out, job)


def train(task: Task, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Train, from the weights of another training where given, and export the best policy."""
    trainer = Trainer(task, job)
    if "start" in inputs:
        trainer.start_from(inputs["start"][0] / WEIGHTS)
    trainer.run()
    return trainer.export(out)


def task(
    section: Section, inputs: Inputs, guided: bool, underlying: Underlying | None = None
) -> Task:
    """The task of a stage's section and inputs."""
    robot, env = from_dict(RobotConfig, section["robot"]), from_dict(EnvConfig, section["env"])
    settings = from_dict(TrainConfig, section["train"])
    library = inputs["library"][0] / STORE if "library" in inputs else None
    return task_of(robot, env, settings, library, guided, underlying)
