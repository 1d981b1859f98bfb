"""Typed settings of hybrid zero dynamics: virtual constraints, foot placement, stability."""

from dataclasses import asdict, fields
from typing import Annotated, Any, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from slider.config.types import (
    STRICT,
    Count,
    Distinct,
    Interval,
    Metres,
    MetresPerSecond,
    NonNegative,
    Number,
    Positive,
    Radians,
    RadiansPerSecond,
    Share,
    Some,
    Tolerance,
    Unit,
    ordered,
)

PerSecond = Annotated[float, Unit("1/s"), Field(ge=0, le=1e4)]
PerSecond2 = Annotated[float, Unit("1/s²"), Field(ge=0, le=1e6)]


@dataclass(frozen=True, config=STRICT)
class VirtualConstraintsConfig:
    """Outputs, their phase and what enforces them."""

    outputs: Literal["absolute", "joints"]
    """absolute: torso, swing leg and swing foot in the world; joints: the joints themselves"""
    phase: Literal["time", "hip"]
    """time: the clock; hip: how far the hip is ahead of the stance foot"""
    slowest_hip: Positive[MetresPerSecond]
    """gaits with less forward velocity have time for a phase"""
    correction_end: Positive[Share]
    """phase at which the re-anchoring after an impact is over"""
    placement: Annotated[Interval[Share], ordered("lower", "upper", strict=True)]
    """phases between which the swing foot is displaced"""
    kp: Positive[PerSecond2]
    """of the outputs"""
    kd: Positive[PerSecond]
    """of the outputs' rates"""
    rate_gain: Positive[PerSecond]
    """of the phase's rate, where the hip is the phase"""


@dataclass(frozen=True, config=STRICT)
class FootPlacementConfig:
    """Event-based feedback: the linear-quadratic regulator of the step-to-step dynamics."""

    position: Positive[Number]
    """weight of the position of the centre of mass [1/m²]"""
    velocity: Positive[Number]
    """weight of its velocity [s²/m²]"""
    displacement: Positive[Number]
    """weight of the foot's displacement [1/m²]"""
    reach: NonNegative[Metres]
    """greatest displacement in each direction"""


@dataclass(frozen=True, config=STRICT)
class LinearisationConfig:
    """Return map by central differences."""

    difference: Annotated[Tolerance, Unit("rad, m, 1/s")]
    """perturbation of the state; twice it checks the differences"""
    tolerance: Annotated[Tolerance, Unit("rad, m, 1/s")]
    """of the fixed point"""


@dataclass(frozen=True, config=STRICT)
class ImpactGrid:
    """Perturbed impacts: every roll with every roll rate."""

    roll: Distinct[Some[Radians]]
    roll_rate: Distinct[Some[RadiansPerSecond]]


@dataclass(frozen=True, config=STRICT)
class BasinConfig:
    """Which perturbed starts return to the limit cycle, with and without foot placement."""

    roll: Interval[Radians]
    """of the perturbation"""
    roll_rate: Interval[RadiansPerSecond]
    """of the perturbation"""
    points: Annotated[Count, Field(ge=2, le=1000)]
    """in each direction"""
    steps: Count
    """after which a walk has returned or not"""
    returned: tuple[Positive[Radians], Positive[RadiansPerSecond]]
    """greatest deviation of roll and roll rate from the limit cycle's then"""


@dataclass(frozen=True, config=STRICT)
class StabilityConfig(VirtualConstraintsConfig):
    """Virtual constraints, and what their stability is measured and made with."""

    ankle: Literal["free", "driven"]
    """free: the stance ankle gives what the gait asks for, however the robot moves, since the
    foot's length leaves it little more; driven: it holds its output or the phase's rate, which
    leaves a foothold nothing to correct forwards"""
    fastest_clock: Positive[MetresPerSecond]
    """gaits with more forward velocity are not linearised by time as well: no foot placement
    stabilises them there"""
    feedback: FootPlacementConfig
    linearisation: LinearisationConfig


@dataclass(frozen=True, config=STRICT)
class BasinsConfig(BasinConfig):
    """Basins of attraction of a few gaits."""

    gaits: Some[tuple[MetresPerSecond, MetresPerSecond]]
    """vx, vy; those that the library does not ask for are left out"""


@dataclass(frozen=True, config=STRICT)
class HzdConfig(StabilityConfig):
    """All of hybrid zero dynamics."""

    impacts: ImpactGrid
    """at which hybrid invariance is measured"""
    basin: BasinsConfig
    steps: Count
    """that a gait is to walk in MuJoCo"""
    chunk: Count
    """gaits per job"""


def enforced_section(config: HzdConfig) -> dict[str, Any]:
    """What a controller needs of it: the constraints, and how far a foothold may go."""
    names = [field.name for field in fields(VirtualConstraintsConfig)]
    values = asdict(config)
    return {"constraints": {n: values[n] for n in names}, "reach": config.feedback.reach}
