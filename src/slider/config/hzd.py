"""Typed settings of hybrid zero dynamics: virtual constraints, foot placement, stability."""

from dataclasses import asdict, fields
from typing import Annotated, Any

from pydantic import Field

from slider.config import types as t

PerSecond = Annotated[float, t.Unit("1/s"), Field(ge=0, le=1e4)]
PerSecond2 = Annotated[float, t.Unit("1/s²"), Field(ge=0, le=1e6)]


class VirtualConstraintsConfig(t.Group):
    """Outputs, their phase and what enforces them."""

    slowest_hip: t.Positive[t.MetresPerSecond]
    """forward velocity below which time is a gait's phase variable; above, the hip position"""
    correction_end: t.Positive[t.Share]
    """phase at which the correction of the constraints after an impact has decayed"""
    placement: Annotated[t.Interval[t.Share], t.ordered("lower", "upper", strict=True)]
    """phases between which the swing foot moves to its corrected foothold"""
    kp: t.Positive[PerSecond2]
    """proportional gain of the outputs"""
    kd: t.Positive[PerSecond]
    """derivative gain of the outputs"""
    rate_gain: t.Positive[PerSecond]
    """gain on the rate of the phase, where the hip position is the phase variable"""


class FootPlacementConfig(t.Group):
    """Event-based feedback: the linear-quadratic regulator of the step-to-step dynamics."""

    position: t.Positive[t.Number]
    """weight of the position of the centre of mass [1/m²]"""
    velocity: t.Positive[t.Number]
    """weight of its velocity [s²/m²]"""
    displacement: t.Positive[t.Number]
    """weight of the foot's displacement [1/m²]"""
    reach: t.NonNegative[t.Metres]
    """largest displacement of the foothold in each direction"""


class LinearisationConfig(t.Group):
    """Linearisation of the return map by central differences."""

    difference: Annotated[t.Tolerance, t.Unit("rad, m, 1/s")]
    """perturbation of the state; twice this size is used to check the differences"""
    tolerance: Annotated[t.Tolerance, t.Unit("rad, m, 1/s")]
    """tolerance of the fixed point"""


class StabilityConfig(VirtualConstraintsConfig):
    """Virtual constraints, foot placement that stabilises them, and linearisation."""

    fastest_clock: t.Positive[t.MetresPerSecond]
    """forward velocity up to which gaits are also linearised with time as the phase variable;
    no foot placement stabilises faster ones that way"""
    feedback: FootPlacementConfig
    linearisation: LinearisationConfig


class HzdConfig(StabilityConfig):
    """All settings of hybrid zero dynamics."""

    steps: t.Count
    """steps that a gait is to walk in MuJoCo"""
    chunk: t.Count
    """gaits per job"""


def enforced_section(config: HzdConfig) -> dict[str, Any]:
    """Settings that a controller needs: the constraints and the reach of foot placement."""
    names = [field.name for field in fields(VirtualConstraintsConfig)]
    values = asdict(config)
    return {"constraints": {n: values[n] for n in names}, "reach": config.feedback.reach}
