"""Typed settings of evaluation, tracking and resources."""

from dataclasses import field

from pydantic.dataclasses import dataclass

from slider.core.config.disturbance import DisturbanceConfig
from slider.core.config.env import StartNoise
from slider.core.config.strict import STRICT


@dataclass(frozen=True, config=STRICT)
class EvaluationConfig:
    """The paper's protocol: every controller, command, trial and robot; see ``docs/method.md``.

    ``controllers`` and ``commands`` say which evaluations there are; they are not in the section
    of a single one, which would otherwise be redone with every new command.
    """

    trials: int
    robots: int
    duration: float
    steady_from: float
    tracking_tolerance: float
    tracking_relative: float
    seed: int
    start: StartNoise
    disturbance: DisturbanceConfig
    controllers: list[str] = field(default_factory=list)
    commands: list[float] = field(default_factory=list)


@dataclass(frozen=True, config=STRICT)
class TrackingConfig:
    """MLflow: whether runs are recorded, and the name of the experiment."""

    enabled: bool
    experiment: str


@dataclass(frozen=True, config=STRICT)
class ResourcesConfig:
    """Threads of a training or evaluation job. Never part of a recipe."""

    threads: int
