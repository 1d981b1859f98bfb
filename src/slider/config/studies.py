"""Typed settings of the studies beside the way to Table 1: variants, and what is compared."""

from typing import Annotated

from pydantic import Field
from pydantic.dataclasses import dataclass

from slider.config.gait import StartSpread
from slider.config.robot import Provenance
from slider.config.types import (
    STRICT,
    Count,
    Distinct,
    MetresPerSecond,
    Name,
    Seed,
    Share,
    Some,
    Tolerance,
)

Samples = Annotated[int, Field(ge=1, le=1_000_000_000_000)]


@dataclass(frozen=True, config=STRICT)
class VariantConfig:
    """One row of a study: its name for people, and Hydra overrides of the configuration."""

    label: Name
    """name in table and figure"""
    overrides: list[Name]
    """of the configuration that the pipeline was given"""


@dataclass(frozen=True, config=STRICT)
class ScalingConfig:
    """Further variants: numbers of the robot, each multiplied by two factors, one at a time."""

    change: Annotated[Share, Field(gt=0, lt=1)]
    """the factors are 1 − this and 1 + this"""
    provenance: Distinct[Some[Provenance]]
    """tags of the numbers that vary"""
    parameters: list[Name]
    """dotted names below robot, or groups of them; empty: all with these tags"""


@dataclass(frozen=True, config=STRICT)
class StartsConfig:
    """Random initial guesses of each gait, each solved by itself."""

    count: Count
    """per variant and speed"""
    seed: Seed
    """start k is the same at every speed, however many there are"""
    same_cost: Tolerance
    """relative difference of cost up to which two solutions count as one optimum"""
    spread: StartSpread


@dataclass(frozen=True, config=STRICT)
class BudgetConfig:
    """Trainings of each variant, the same length for all."""

    seeds: Distinct[Some[Seed]]
    """of standing and walking; one training each"""
    samples: Samples
    """control steps of a robot, of a walking training"""
    pretraining_samples: Samples
    """of a standing training, where there is one"""
    check_every: Samples
    """samples between checks: the points of the learning curves"""


@dataclass(frozen=True, config=STRICT)
class RolloutsConfig:
    """Evaluations of each policy; all else is as in ``evaluation``."""

    trials: Annotated[Count, Field(le=100_000)]
    """each with a seed of its own"""
    robots: Count
    """per trial"""
    seed: Seed
    """of the first trial"""


@dataclass(frozen=True, config=STRICT)
class StudyConfig:
    """Variants and the metrics that are compared; ``conf/study/NAME.yaml`` is the target NAME."""

    run: Distinct[Some[Name]]
    """variants that are compared, in this order; the first one is the reference"""
    variants: dict[str, VariantConfig]
    speeds: Distinct[Some[MetresPerSecond]]
    """forward velocities of gaits and evaluations"""
    metrics: Distinct[Some[Name]]
    """columns of NAME_runs.csv that are compared; the figure has the first five"""
    scaling: ScalingConfig | None = None
    """further variants; null: none"""
    gaits: bool = False
    """solve the gaits of each variant"""
    starts: StartsConfig | None = None
    """solve them from random guesses too; null: not"""
    training: BudgetConfig | None = None
    """train each variant; null: the pipeline's policy, not retrained, on each variant's robot"""
    evaluation: RolloutsConfig | None = None
    """evaluate the policies; null: none"""
