"""The stages ``standing`` and ``walking``."""

from pathlib import Path

from slider.core.config.convert import from_dict
from slider.core.config.env import EnvConfig
from slider.core.config.robot import RobotConfig
from slider.core.config.train import TrainConfig
from slider.core.job import Inputs, Job, Section, Summary
from slider.env.guide import Guide
from slider.library.lookup import GaitLibrary, GaitTable
from slider.training.trainer import WEIGHTS, Task, Trainer


def run_standing(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Pre-train a policy that stands; the library gives the pace of the clock only."""
    task = _task(section, inputs, guided=False)
    return _train(task, None, out, job)


def run_walking(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Train walking from the standing weights, guided by the gait library."""
    task = _task(section, inputs, guided=True)
    return _train(task, inputs["standing"][0] / WEIGHTS, out, job)


def _train(task: Task, weights: Path | None, out: Path, job: Job) -> Summary:
    trainer = Trainer(task, job)
    if weights is not None:
        trainer.start_from(weights)
    trainer.run()
    return trainer.export(out)


def _task(section: Section, inputs: Inputs, guided: bool) -> Task:
    env = from_dict(EnvConfig, section["env"])
    library = GaitLibrary.load(inputs["library"][0] / "library.zarr")
    table = GaitTable.from_library(library)
    return Task(
        robot=from_dict(RobotConfig, section["robot"]),
        env=env,
        train=from_dict(TrainConfig, section["train"]),
        times=table.times if env.phase.enabled else None,
        guide=Guide(library, table) if guided else None,
    )
