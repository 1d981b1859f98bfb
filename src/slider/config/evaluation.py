"""Typed settings of evaluation protocols, tracking and resources."""

from dataclasses import field

from pydantic.dataclasses import dataclass

from slider.config.disturbance import DisturbanceConfig
from slider.config.env import StartNoise
from slider.config.strict import STRICT


@dataclass(frozen=True, config=STRICT)
class Segment:
    """From ``time`` [s] on: vx, vy [m/s] and yaw rate [rad/s], until the next segment."""

    name: str
    time: float
    vx: float
    vy: float = 0.0
    yaw_rate: float = 0.0


@dataclass(frozen=True, config=STRICT)
class CaseConfig:
    """One rollout: its segments in the order of time, the first one from 0 s on."""

    name: str
    segments: list[Segment]


@dataclass(frozen=True, config=STRICT)
class ProfileConfig:
    """Commands that change during a rollout; see ``docs/how-to/evaluate.md``.

    ``rows`` and ``cases`` are not in the section of a single evaluation, which has its own case.

    Attributes:
        ramp: how long a command takes to get from one segment's to the next one's [s].
        warm_up: start of each segment that does not count for its errors [s].
        window: moving average over which velocities are drawn [s].
        rows: of the report's table: ``segments`` of its only case, or ``cases`` by their last one.
        cases: each is a rollout of its own.
    """

    ramp: float
    warm_up: float
    window: float
    rows: str = "segments"
    cases: list[CaseConfig] = field(default_factory=list)


@dataclass(frozen=True, config=STRICT)
class EvaluationConfig:
    """A protocol: every controller, command, trial and robot; see ``docs/explanation/method.md``.

    ``controllers`` and ``commands`` say which evaluations there are; they are not in the section
    of a single one, which would otherwise be redone with every new command. A protocol has either
    ``commands``, constant forward velocities, or a ``profile``.
    """

    trials: int
    robots: int
    duration: float
    warm_up: float
    tracking_tolerance: float
    tracking_relative: float
    seed: int
    start: StartNoise
    disturbance: DisturbanceConfig
    controllers: list[str] = field(default_factory=list)
    commands: list[float] = field(default_factory=list)
    profile: ProfileConfig | None = None


@dataclass(frozen=True, config=STRICT)
class TrackingConfig:
    """MLflow: whether runs are recorded, and the name of the experiment."""

    enabled: bool
    experiment: str


@dataclass(frozen=True, config=STRICT)
class ResourcesConfig:
    """Threads of a training or evaluation job. Never part of a recipe."""

    threads: int
