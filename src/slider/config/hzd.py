"""Typed settings of hybrid zero dynamics: virtual constraints, foot placement, stability."""

from dataclasses import asdict, fields
from typing import Annotated, Any, Literal

from pydantic import Field

from slider.config import types as t

PerSecond = Annotated[float, t.Unit("1/s"), Field(ge=0, le=1e4)]
PerSecond2 = Annotated[float, t.Unit("1/s²"), Field(ge=0, le=1e6)]


class VirtualConstraintsConfig(t.Group):
    """Outputs, their phase and what enforces them."""

    outputs: Literal["absolute", "joints"]
    """absolute: torso, swing leg and swing foot in the world; joints: the joints themselves"""
    phase: Literal["time", "hip"]
    """time: the clock; hip: how far the hip is ahead of the stance foot"""
    slowest_hip: t.Positive[t.MetresPerSecond]
    """gaits with less forward velocity have time for a phase"""
    correction_end: t.Positive[t.Share]
    """phase at which the re-anchoring after an impact is over"""
    placement: Annotated[t.Interval[t.Share], t.ordered("lower", "upper", strict=True)]
    """phases between which the swing foot is displaced"""
    kp: t.Positive[PerSecond2]
    """of the outputs"""
    kd: t.Positive[PerSecond]
    """of the outputs' rates"""
    rate_gain: t.Positive[PerSecond]
    """of the phase's rate, where the hip is the phase"""


class FootPlacementConfig(t.Group):
    """Event-based feedback: the linear-quadratic regulator of the step-to-step dynamics."""

    position: t.Positive[t.Number]
    """weight of the position of the centre of mass [1/m²]"""
    velocity: t.Positive[t.Number]
    """weight of its velocity [s²/m²]"""
    displacement: t.Positive[t.Number]
    """weight of the foot's displacement [1/m²]"""
    reach: t.NonNegative[t.Metres]
    """greatest displacement in each direction"""


class LinearisationConfig(t.Group):
    """Return map by central differences."""

    difference: Annotated[t.Tolerance, t.Unit("rad, m, 1/s")]
    """perturbation of the state; twice it checks the differences"""
    tolerance: Annotated[t.Tolerance, t.Unit("rad, m, 1/s")]
    """of the fixed point"""


class ImpactGrid(t.Group):
    """Perturbed impacts: every roll with every roll rate."""

    roll: t.Distinct[t.Some[t.Radians]]
    roll_rate: t.Distinct[t.Some[t.RadiansPerSecond]]


class BasinConfig(t.Group):
    """Which perturbed starts return to the limit cycle, with and without foot placement."""

    roll: t.Interval[t.Radians]
    """of the perturbation"""
    roll_rate: t.Interval[t.RadiansPerSecond]
    """of the perturbation"""
    points: Annotated[t.Count, Field(ge=2, le=1000)]
    """in each direction"""
    steps: t.Count
    """after which a walk has returned or not"""
    returned: tuple[t.Positive[t.Radians], t.Positive[t.RadiansPerSecond]]
    """greatest deviation of roll and roll rate from the limit cycle's then"""


class StabilityConfig(VirtualConstraintsConfig):
    """Virtual constraints, and what their stability is measured and made with."""

    ankle: Literal["free", "driven"]
    """free: the stance ankle gives what the gait asks for, however the robot moves, since the
    foot's length leaves it little more; driven: it holds its output or the phase's rate, which
    leaves a foothold nothing to correct forwards"""
    fastest_clock: t.Positive[t.MetresPerSecond]
    """gaits with more forward velocity are not linearised by time as well: no foot placement
    stabilises them there"""
    feedback: FootPlacementConfig
    linearisation: LinearisationConfig


class BasinsConfig(BasinConfig):
    """Basins of attraction of a few gaits."""

    gaits: t.Some[tuple[t.MetresPerSecond, t.MetresPerSecond]]
    """vx, vy; those that the library does not ask for are left out"""


class HzdConfig(StabilityConfig):
    """All of hybrid zero dynamics."""

    impacts: ImpactGrid
    """at which hybrid invariance is measured"""
    basin: BasinsConfig
    steps: t.Count
    """that a gait is to walk in MuJoCo"""
    chunk: t.Count
    """gaits per job"""


def enforced_section(config: HzdConfig) -> dict[str, Any]:
    """What a controller needs of it: the constraints, and how far a foothold may go."""
    names = [field.name for field in fields(VirtualConstraintsConfig)]
    values = asdict(config)
    return {"constraints": {n: values[n] for n in names}, "reach": config.feedback.reach}
