"""Typed settings of the two trainings (standing, walking)."""

from dataclasses import field

from pydantic.dataclasses import dataclass

from slider.config.disturbance import DisturbanceConfig
from slider.config.interval import Interval
from slider.config.strict import STRICT


@dataclass(frozen=True, config=STRICT)
class CurriculumConfig:
    """Commands grow with success: their ranges are a share of the configured ones.

    The share begins at ``start`` and grows by ``growth`` whenever at least ``success`` of as many
    episodes as there are robots ended without a fall; a start of 1 is no curriculum.
    """

    start: float
    growth: float
    success: float


@dataclass(frozen=True, config=STRICT)
class CommandConfig:
    """Ranges of the commanded velocities and how often they change.

    vx, vy [m/s]; yaw rate [rad/s]; ``period`` [s] is the mean time between changes (0: never);
    ``standing_fraction`` of the commands are zero.
    """

    vx: Interval
    vy: Interval
    yaw_rate: Interval
    period: float
    standing_fraction: float
    curriculum: CurriculumConfig


@dataclass(frozen=True, config=STRICT)
class GuideConfig:
    """Which gait guides a command between those of the library: ``interpolated``, ``nearest``."""

    gait: str


@dataclass(frozen=True, config=STRICT)
class RewardTerm:
    """Weight of a reward term and its parameters."""

    weight: float
    params: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True, config=STRICT)
class RewardConfig:
    """Weighted sum of terms, times ``scale``, at least ``floor``; then ``on_fall`` is added."""

    terms: dict[str, RewardTerm]
    scale: float
    floor: float
    on_fall: float

    @property
    def active(self) -> dict[str, RewardTerm]:
        """Terms that count: a weight of 0 switches a term off."""
        return {name: term for name, term in self.terms.items() if term.weight != 0}


@dataclass(frozen=True, config=STRICT)
class ResetConfig:
    """Share of episodes that start on the reference gait instead of at rest."""

    reference_fraction: float


@dataclass(frozen=True, config=STRICT)
class NetworkConfig:
    """Actor and critic: multilayer perceptrons of the same shape.

    The standard deviation of the action noise is learned between ``std_min`` and a bound:
    ``std_max`` until the share ``anneal_from`` of the iterations, then falling geometrically to
    ``std_final``.
    """

    hidden: list[int]
    activation: str
    initial_std: float
    std_min: float
    std_max: float
    std_final: float
    anneal_from: float
    output_scale: float


@dataclass(frozen=True, config=STRICT)
class PpoConfig:
    """Proximal policy optimisation with generalised advantage estimation.

    ``actor_ema`` is the share of the old average of the actor that an update leaves; the average
    is what is exported.
    """

    learning_rate: float
    schedule: str
    desired_kl: float
    epochs: int
    mini_batches: int
    clip: float
    gamma: float
    lam: float
    value_coefficient: float
    entropy_coefficient: float
    max_grad_norm: float
    precision: str
    symmetry: str
    symmetry_weight: float
    actor_ema: float


@dataclass(frozen=True, config=STRICT)
class SelectionConfig:
    """Periodic small evaluation that picks the checkpoint to keep."""

    interval: int
    commands: list[float]
    robots: int
    seed: int
    duration: float
    warm_up: float
    fall_weight: float
    flight_weight: float


@dataclass(frozen=True, config=STRICT)
class TrainConfig:
    """One training run."""

    iterations: int
    robots: int
    steps_per_iteration: int
    episode_length: float
    seed: int
    commands: CommandConfig
    guide: GuideConfig
    reward: RewardConfig
    reset: ResetConfig
    network: NetworkConfig
    ppo: PpoConfig
    selection: SelectionConfig
    disturbance: DisturbanceConfig


@dataclass(frozen=True, config=STRICT)
class TrainingsConfig:
    """Standing pre-training (if ``pretraining``), then walking."""

    pretraining: bool
    standing: TrainConfig
    walking: TrainConfig
