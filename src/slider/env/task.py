"""A training task: robot, environment, rewards, and the gaits that it needs."""

from dataclasses import dataclass
from pathlib import Path

from slider.config.env import EnvConfig
from slider.config.robot import RobotConfig
from slider.config.train import TrainConfig
from slider.env.guide import Guide
from slider.library.lookup import GaitTable, JointTable, StepTimes
from slider.library.reader import GaitLibrary


@dataclass(frozen=True)
class Task:
    """One training.

    Attributes:
        robot, env, train: the configuration.
        times: step times of the clock, where there is one.
        guide: the library's gaits for guide rewards and starts; none where training is unguided.
        reference: joint positions of the gaits, where actions are about the gait.
    """

    robot: RobotConfig
    env: EnvConfig
    train: TrainConfig
    times: StepTimes | None
    guide: Guide | None
    reference: JointTable | None = None


def task_of(
    robot: RobotConfig,
    env: EnvConfig,
    train: TrainConfig,
    library: Path | None,
    guided: bool = True,
) -> Task:
    """The task that a configuration describes.

    Args:
        robot, env, train: the configuration.
        library: Zarr gait library, if the training has one.
        guided: whether rewards and starts use its gaits.
    """
    if library is None:
        return Task(robot, env, train, _times(env, None), None)
    gaits = GaitLibrary.load(library)
    table = GaitTable.from_library(gaits)
    guide = Guide(gaits, table, train.guide.gait) if guided else None
    reference = table.joints if env.action.offset == "gait" else None
    return Task(robot, env, train, _times(env, table), guide, reference)


def _times(env: EnvConfig, table: GaitTable | None) -> StepTimes | None:
    """Step times of the clock, if it has any: fixed, or those of the gaits."""
    if not env.phase.enabled:
        return None
    if env.phase.step_time > 0:
        return StepTimes.constant(env.phase.step_time)
    return None if table is None else table.times
