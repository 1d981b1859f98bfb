"""Typed settings of the sensitivity: which parameters of the robot vary, and what is looked at."""

from typing import Annotated

from pydantic import Field
from pydantic.dataclasses import dataclass

from slider.config.robot import Provenance
from slider.config.types import (
    STRICT,
    Count,
    Distinct,
    MetresPerSecond,
    Name,
    Positive,
    Seconds,
    Share,
    Some,
)


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
