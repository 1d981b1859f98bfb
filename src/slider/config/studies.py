"""Typed settings of the studies beside the way to Table 1: ablation, sensitivity and gaits."""

from typing import Annotated

from pydantic import Field
from pydantic.dataclasses import dataclass

from slider.config.gait import Nodes, StartSpread
from slider.config.robot import Provenance
from slider.config.types import (
    STRICT,
    Count,
    Distinct,
    MetresPerSecond,
    Name,
    Positive,
    Seconds,
    Seed,
    Share,
    Some,
    Tolerance,
)

Samples = Annotated[int, Field(ge=1, le=1_000_000_000_000)]


@dataclass(frozen=True, config=STRICT)
class VariantConfig:
    """One row of the ablation: what people call it, and Hydra overrides of the configuration."""

    label: Name
    """name in table and figure"""
    overrides: list[Name]
    """of the configuration that the pipeline was given"""


@dataclass(frozen=True, config=STRICT)
class AblationConfig:
    """Variants that are trained, how long, how often, and where they are evaluated."""

    run: Distinct[Some[Name]]
    """variants that are compared, in this order"""
    seeds: Distinct[Some[Seed]]
    """of standing and walking; one training each"""
    samples: Samples
    """control steps of a robot, of a walking training; for all variants the same"""
    pretraining_samples: Samples
    """of a standing training, where there is one"""
    check_every: Samples
    """samples between checks: the points of the learning curves"""
    commands: Distinct[Some[MetresPerSecond]]
    """evaluated forward velocities"""
    trials: Annotated[Count, Field(le=100_000)]
    """of the protocol (evaluation)"""
    robots: Count
    """per trial"""
    evaluation_seed: Seed
    """of the first trial"""
    variants: dict[str, VariantConfig]


@dataclass(frozen=True, config=STRICT)
class SensitivityConfig:
    """Parameters of the robot that vary one at a time, and what is solved and rolled out."""

    change: Annotated[Share, Field(gt=0, lt=1)]
    """each parameter is multiplied by 1 − this and by 1 + this, one at a time"""
    provenance: Distinct[Some[Provenance]]
    """tags of the parameters that vary"""
    parameters: list[Name]
    """dotted names below robot, or groups of them; empty: all with these tags"""
    commands: Distinct[Some[MetresPerSecond]]
    """forward velocities of the gaits and of the policy"""
    robots: Count
    """per changed robot and command, each with its own start"""
    duration: Positive[Seconds]
    """of a rollout; starts and disturbance are those of evaluation"""
    warm_up: Seconds
    """start of mse_steady and of the mean velocity"""
    gaits: bool
    """solve the gaits of each changed robot"""
    policy: bool
    """roll the policy out, not retrained, on each changed robot"""


@dataclass(frozen=True, config=STRICT)
class StartsConfig:
    """Random initial guesses of a gait, each solved by itself."""

    number: Count
    """per commanded velocity"""
    seed: Seed
    """start k is the same at every velocity, however many there are"""
    spread: StartSpread


@dataclass(frozen=True, config=STRICT)
class GaitStudyConfig:
    """Meshes and random starts of the gait optimisation."""

    commands: Distinct[Some[MetresPerSecond]]
    """forward velocities of the gaits"""
    nodes: Distinct[Some[Nodes]]
    """meshes, nodes per step; the others are compared with the finest"""
    same_cost: Tolerance
    """relative difference of cost up to which two solutions count as one optimum"""
    starts: StartsConfig
