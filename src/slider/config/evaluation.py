"""Typed settings of evaluation protocols, and the seeds that they draw from."""

from dataclasses import field
from typing import Annotated, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from slider.config.env import DisturbanceConfig, StartNoise
from slider.config.types import (
    STRICT,
    Count,
    Distinct,
    Factor,
    MetresPerSecond,
    Name,
    NonNegative,
    Positive,
    RadiansPerSecond,
    Seconds,
    Seed,
    Some,
)


@dataclass(frozen=True, config=STRICT)
class SpeedsConfig:
    """Commanded forward velocities that several parts of the configuration share."""

    table1: Distinct[Some[MetresPerSecond]]
    """of Table 1"""
    top: Positive[MetresPerSecond]
    """the highest one, of gaits, trainings and the viewer"""


@dataclass(frozen=True, config=STRICT)
class Segment:
    """A constant velocity, until the next segment."""

    name: Name
    time: Seconds
    """from when on"""
    vx: MetresPerSecond
    vy: MetresPerSecond = 0.0
    yaw_rate: RadiansPerSecond = 0.0


@dataclass(frozen=True, config=STRICT)
class CaseConfig:
    """One rollout: its segments in the order of time, the first one from 0 s on."""

    name: Name
    segments: Some[Segment]


@dataclass(frozen=True, config=STRICT)
class ProfileConfig:
    """Velocities that change during a rollout; see ``docs/how-to/evaluate.md``.

    ``rows`` and ``cases`` are not in the section of a single evaluation, which has its own case.
    """

    ramp: Seconds
    """duration of the change from a segment's velocity to the next one's; 0: a step"""
    warm_up: Seconds
    """start of each segment that does not count for its errors"""
    window: Positive[Seconds]
    """moving average over which velocities are drawn"""
    rows: Literal["segments", "cases"] = "segments"
    """of the report's table: segments of the only case, or cases, each by its last segment"""
    cases: Some[CaseConfig] = field(default_factory=list)
    """rollouts: from a time on, vx, vy and yaw_rate, 0 if not said"""


@dataclass(frozen=True, config=STRICT)
class EvaluationConfig:
    """A protocol: every controller, velocity, trial and robot; see ``docs/explanation/method.md``.

    ``controllers`` and ``speeds`` say which evaluations there are; they are not in the section
    of a single one, which would otherwise be redone with every new speed. A protocol has either
    ``speeds``, constant forward velocities, or a ``profile``.
    """

    trials: Annotated[Count, Field(le=100_000)]
    """trials, each with a seed of its own"""
    robots: Count
    """per trial, each with its own start"""
    duration: Positive[Seconds]
    """of a rollout"""
    warm_up: Seconds
    """start of mse_steady and of the tracked mean velocity"""
    tracking_tolerance: NonNegative[MetresPerSecond]
    """tracked: |mean v − speed| ≤ max(this, tracking_relative · speed)"""
    tracking_relative: Factor
    """the same relative to the commanded speed"""
    seed: Seed
    """of the first trial"""
    start: StartNoise
    disturbance: DisturbanceConfig
    controllers: Distinct[Some[Name]] = field(default_factory=list)
    """rows of the table"""
    speeds: Distinct[list[MetresPerSecond]] = field(default_factory=list)
    """constant forward velocities; none with a profile"""
    profile: ProfileConfig | None = None
    """velocities that change; null: constant ones"""


@dataclass(frozen=True, config=STRICT)
class SeedBlock:
    """Consecutive seeds, ``first`` and ``last`` included."""

    first: Seed
    last: Seed

    def __contains__(self, seed: int) -> bool:
        return self.first <= seed <= self.last

    def __str__(self) -> str:
        return f"{self.first} to {self.last}"


@dataclass(frozen=True, config=STRICT)
class SeedsConfig:
    """Blocks of seeds that are held apart: nothing is chosen by results from ``final``.

    Trial k of an evaluation draws its starts from its seed + k.
    """

    final: SeedBlock
    development: SeedBlock
    selection: Seed
    """of development: the checks that pick a training's checkpoint"""
