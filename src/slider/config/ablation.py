"""Typed settings of the ablation: what is compared, at what cost."""

from typing import Annotated

from pydantic import Field
from pydantic.dataclasses import dataclass

from slider.config.types import STRICT, Count, Distinct, MetresPerSecond, Name, Seed, Some

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
