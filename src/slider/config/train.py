"""Typed settings of the trainings."""

from dataclasses import field
from typing import Annotated, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from slider.config.env import DisturbanceConfig, Sensing
from slider.config.types import (
    STRICT,
    Count,
    Distinct,
    Factor,
    Interval,
    MetresPerSecond,
    NonNegative,
    Number,
    Positive,
    RadiansPerSecond,
    Rule,
    Seconds,
    Seed,
    Share,
    Some,
    ordered,
)

WARP = "slider.env.warp"
"""Module of MuJoCo Warp's physics; its code is in the section of the trainings that use it."""


@dataclass(frozen=True, config=STRICT)
class CurriculumConfig:
    """Velocities grow with success: their ranges are a share of the configured ones."""

    start: Positive[Share]
    """share at the start; 1: no curriculum"""
    growth: Positive[Factor]
    """added to the share"""
    success: Positive[Share]
    """share of as many episodes as there are robots that must end without a fall"""


@dataclass(frozen=True, config=STRICT)
class VelocitiesConfig:
    """Ranges of the commanded velocities, drawn uniformly, and how often they change."""

    vx: Interval[MetresPerSecond]
    vy: Interval[MetresPerSecond]
    yaw_rate: Interval[RadiansPerSecond]
    period: Seconds
    """mean time between changes; 0: never within an episode"""
    standing_fraction: Share
    """share of zero velocities"""
    curriculum: CurriculumConfig
    uneven: Annotated[Share, Field(gt=0)]
    """on ground that is not flat velocities are this share of those drawn"""


@dataclass(frozen=True, config=STRICT)
class GuideConfig:
    """Which gait guides a velocity between those of the library."""

    gait: Literal["interpolated", "nearest"]
    """between the gaits of the library; interpolated: at the reference velocity"""


@dataclass(frozen=True, config=STRICT)
class RewardTerm:
    """Weight of a reward term and its parameters."""

    weight: Number
    """factor on the term; 0 switches it off"""
    params: dict[str, float] = field(default_factory=dict)
    """parameter of the term, which says its bounds"""


@dataclass(frozen=True, config=STRICT)
class RewardConfig:
    """max(weighted sum of terms, ``floor``) · ``scale`` + ``on_fall``."""

    terms: Annotated[dict[str, RewardTerm], Field(min_length=1)]
    scale: Positive[Number]
    """factor on the sum of the terms"""
    floor: Number
    """least value of the sum, before ``scale``"""
    on_fall: Number
    """added when the episode ends in a fall"""

    @property
    def active(self) -> dict[str, RewardTerm]:
        """Terms that count: a weight of 0 switches a term off."""
        return {name: term for name, term in self.terms.items() if term.weight != 0}


@dataclass(frozen=True, config=STRICT)
class ResetConfig:
    """How episodes start."""

    reference_fraction: Share
    """share of episodes that start on the gait; the others start at rest"""


@dataclass(frozen=True, config=STRICT)
class NetworkConfig:
    """Actor and critic: multilayer perceptrons of the same shape.

    The standard deviation of the action noise is learned between ``std_min`` and a bound:
    ``std_max`` until the share ``anneal_from`` of the iterations, then falling geometrically to
    ``std_final``.
    """

    hidden: Some[Annotated[Count, Field(le=65536)]]
    """widths of the hidden layers, actor and critic alike"""
    activation: Literal["elu", "relu", "tanh"]
    """of the hidden layers"""
    initial_std: Positive[Factor]
    """of the action noise at the start"""
    std_min: Positive[Factor]
    """least action noise"""
    std_max: Positive[Factor]
    """greatest action noise"""
    std_final: Positive[Factor]
    """greatest action noise at the end"""
    anneal_from: Positive[Share]
    """share of the iterations from which the greatest action noise falls, geometrically"""
    output_scale: Positive[Factor]
    """factor on the last layer's initial weights: small first actions"""


@dataclass(frozen=True, config=STRICT)
class PpoConfig:
    """Proximal policy optimisation with generalised advantage estimation."""

    learning_rate: Positive[Factor]
    """at the start, where the schedule adapts it"""
    schedule: Literal["adaptive", "fixed"]
    """adaptive: follow desired_kl"""
    desired_kl: Positive[Factor]
    """divergence per update that the adaptive schedule aims at"""
    epochs: Annotated[Count, Field(le=1000)]
    """passes over the samples of an update"""
    mini_batches: Count
    """per pass"""
    clip: Positive[Factor]
    """of the probability ratio and of the value"""
    gamma: Positive[Share]
    """discount per control step"""
    lam: Share
    """λ of the generalised advantage estimate"""
    value_coefficient: Factor
    """weight of the value loss"""
    entropy_coefficient: Factor
    """weight of the entropy bonus"""
    max_grad_norm: Positive[Number]
    """gradients are cut to this norm"""
    precision: Literal["auto", "float32", "bfloat16"]
    """of the update; auto: bfloat16 on a processor that has it, found when jobs are laid out"""
    symmetry: Literal["none", "augmentation", "loss"]
    """left and right: reflected samples too, or a mirror loss; with env.phase.mirror=false"""
    symmetry_weight: Factor
    """of the mirror loss"""
    actor_ema: Annotated[Share, Field(lt=1)]
    """share of the actor's old average that an update leaves; the average is judged and exported"""


@dataclass(frozen=True, config=STRICT)
class SelectionConfig:
    """Periodic small evaluation that picks the checkpoint to keep."""

    interval: Count
    """iterations between checks; a checkpoint is written at the same time"""
    speeds: Distinct[Some[MetresPerSecond]]
    """forward velocities of the checks"""
    robots: Count
    """per speed"""
    seed: Seed
    """of the starts, the same ones in every check"""
    duration: Positive[Seconds]
    warm_up: Seconds
    """start that does not count for the error"""
    fall_weight: Positive[Number]
    """score of a robot that fell; one that tracks badly has less than half of it"""
    flight_weight: NonNegative[Number]
    """score of the share of time without contact"""


@dataclass(frozen=True, config=STRICT)
class TrainConfig:
    """One training run."""

    iterations: Annotated[int, Field(ge=0, le=10_000_000)]
    """updates; samples = iterations × robots × steps_per_iteration"""
    simulator: Literal["mujoco", "mujoco_warp"]
    """mujoco: on the processor; mujoco_warp: all robots at once on the device, extra gpu"""
    device: Literal["cpu", "cuda", "auto"]
    """of physics and networks; auto: cuda where there is one, found when jobs are laid out"""
    gpus: Annotated[Count, Field(le=64)]
    """of one machine, each with a process and ``robots`` of its own; gradients are averaged"""
    robots: Count
    """robots simulated at once"""
    steps_per_iteration: Annotated[Count, Field(le=100_000)]
    """control steps of each robot between updates"""
    episode_length: Positive[Seconds]
    """after which a robot starts anew"""
    seed: Seed
    """of networks, environments and noise"""
    velocities: VelocitiesConfig
    guide: GuideConfig
    reward: RewardConfig
    reset: ResetConfig
    network: Annotated[
        NetworkConfig, ordered("std_min", "std_max"), ordered("std_min", "std_final")
    ]
    ppo: PpoConfig
    selection: Annotated[
        SelectionConfig,
        Rule(
            "flight_weight ≤ half of fall_weight: a robot that fell costs most",
            lambda selection: selection.flight_weight <= selection.fall_weight / 2,
        ),
    ]
    disturbance: DisturbanceConfig
    sensing: Sensing
    """what agents receive: the true state, or its estimate from sensors on board"""


@dataclass(frozen=True, config=STRICT)
class TrainingsConfig:
    """Standing pre-training, then walking."""

    pretraining: bool
    """walking starts from the standing policy; false: from scratch"""
    standing: TrainConfig
    walking: TrainConfig
