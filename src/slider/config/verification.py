"""Typed settings of the independent checks of gaits."""

from typing import Annotated, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from slider.config.types import (
    STRICT,
    Count,
    Factor,
    Metres,
    MetresPerSecond,
    Newtons,
    NonNegative,
    Number,
    Positive,
    Radians,
    Rule,
    Seconds,
    Share,
    Some,
    Tolerance,
    Unit,
)


@dataclass(frozen=True, config=STRICT)
class IntegratorConfig:
    """Tolerances of DOP853."""

    relative: Tolerance
    absolute: Annotated[Tolerance, Unit("rad, rad/s")]


@dataclass(frozen=True, config=STRICT)
class RegulatorConfig:
    """Step-to-step foot placement of the replay; see ``slider.verification.replay``."""

    lateral: Factor
    """share of the predicted error that a step takes away, sideways"""
    forward: Some[Factor]
    """the same forwards, at the velocities ``speeds``, linear between"""
    speeds: Annotated[
        Some[MetresPerSecond], Rule("rising velocities", lambda values: values == sorted(values))
    ]
    """gait velocities of ``forward``"""
    reach: NonNegative[Metres]
    """greatest change of a foot's place"""
    placement_end: Positive[Share]
    """phase by which the swing foot is over its new place"""
    fade: Positive[Share]
    """phase by which errors left by the impact are gone"""
    descent: NonNegative[MetresPerSecond]
    """speed at which a late swing foot is lowered"""


@dataclass(frozen=True, config=STRICT)
class ReplayConfig:
    """Replay in MuJoCo."""

    steps: Annotated[Count, Field(le=100_000)]
    """length of the walk"""
    timestep: Positive[Seconds]
    """of the physics"""
    substeps: Annotated[Count, Field(le=1000)]
    """of the physics per control step"""
    points: Annotated[Count, Field(ge=2)]
    """of the table of targets, per step"""
    contact: NonNegative[Newtons]
    """force that counts as a touchdown"""
    height: NonNegative[Metres]
    """a lower base has fallen"""
    tilt: Positive[Radians]
    """a base that leans further has fallen"""
    patience: Annotated[Positive[Factor], Unit("step times")]
    """a swing foot that has not landed by then has missed the ground"""
    regulator: RegulatorConfig


@dataclass(frozen=True, config=STRICT)
class CheckConfig:
    """What the checks of a single gait need."""

    integrator: IntegratorConfig
    points: Annotated[Count, Field(ge=2)]
    """per step, for the resampling between nodes"""
    replay: ReplayConfig


@dataclass(frozen=True, config=STRICT)
class VerificationConfig(CheckConfig):
    """All of the verification."""

    chunk: Count
    """gaits per job"""
    on_failure: Literal["error", "report"]
    """report: a bound that does not hold is written down; error: it ends the collecting job"""
    bounds: dict[str, Annotated[NonNegative[Number], Unit("of the quantity")] | None]
    """of the quantity, see docs/reference/verification.md; null: reported only"""
