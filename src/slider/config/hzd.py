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
    """gaits with less forward velocity have time for a phase, others the place of the hip"""
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


class StabilityConfig(VirtualConstraintsConfig):
    """Virtual constraints, and what their stability is measured and made with."""

    fastest_clock: t.Positive[t.MetresPerSecond]
    """gaits with more forward velocity are not linearised by time as well: no foot placement
    stabilises them there"""
    feedback: FootPlacementConfig
    linearisation: LinearisationConfig


class HzdConfig(StabilityConfig):
    """All of hybrid zero dynamics."""

    steps: t.Count
    """that a gait is to walk in MuJoCo"""
    chunk: t.Count
    """gaits per job"""


def enforced_section(config: HzdConfig) -> dict[str, Any]:
    """What a controller needs of it: the constraints, and how far a foothold may go."""
    names = [field.name for field in fields(VirtualConstraintsConfig)]
    values = asdict(config)
    return {"constraints": {n: values[n] for n in names}, "reach": config.feedback.reach}
