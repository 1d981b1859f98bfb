"""Typed settings of evaluation protocols, tracking and resources."""

from dataclasses import field

from pydantic.dataclasses import dataclass

from slider.core.config.disturbance import DisturbanceConfig
from slider.core.config.env import StartNoise
from slider.core.config.strict import STRICT


@dataclass(frozen=True, config=STRICT)
class Segment:
    """From ``time`` [s] on: vx, vy [m/s] and yaw rate [rad/s], until the next segment."""

    name: str
    time: float
    vx: float
    vy: float
    yaw_rate: float


@dataclass(frozen=True, config=STRICT)
class ProfileConfig:
    """A command that changes during a rollout; see ``docs/protocols.md``.

    Attributes:
        ramp: how long a command takes to get from one segment's to the next one's [s].
        settle: start of each segment that does not count for its errors [s].
        window: moving average over which velocities are drawn [s].
        segments: in the order of time; the first one starts at 0.
    """

    ramp: float
    settle: float
    window: float
    segments: list[Segment]


@dataclass(frozen=True, config=STRICT)
class EvaluationConfig:
    """A protocol: every controller, command, trial and robot; see ``docs/method.md``.

    ``controllers`` and ``commands`` say which evaluations there are; they are not in the section
    of a single one, which would otherwise be redone with every new command. A protocol has either
    ``commands``, constant forward velocities, or one ``profile``.
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
