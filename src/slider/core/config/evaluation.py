"""Typed settings of evaluation, tracking and resources."""

from pydantic.dataclasses import dataclass

from slider.core.config.env import StartNoise
from slider.core.config.strict import STRICT


@dataclass(frozen=True, config=STRICT)
class EvaluationConfig:
    """The paper's protocol: every controller, command, trial and robot; see ``docs/method.md``."""

    controllers: list[str]
    commands: list[float]
    trials: int
    robots: int
    duration: float
    steady_from: float
    tracking_tolerance: float
    tracking_relative: float
    seed: int
    start: StartNoise


@dataclass(frozen=True, config=STRICT)
class TrackingConfig:
    """MLflow: whether runs are recorded, and the name of the experiment."""

    enabled: bool
    experiment: str


@dataclass(frozen=True, config=STRICT)
class ResourcesConfig:
    """Threads of a training or evaluation job. Never part of a recipe."""

    threads: int
