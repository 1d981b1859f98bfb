"""Typed settings of the gauge, a benchmark for bipeds; see ``docs/how-to/gauge.md``."""

from dataclasses import field, fields
from typing import Annotated, get_args

from pydantic import Field
from pydantic.dataclasses import dataclass

from slider.config.env import DisturbanceConfig, SensingConfig, StartNoise, TerrainKind
from slider.config.types import (
    STRICT,
    Count,
    Distinct,
    Factor,
    Kilograms,
    MetresPerSecond,
    Name,
    NewtonSeconds,
    Positive,
    Seconds,
    Seed,
    Share,
    Some,
    T,
)

LEVELS = 10
"""of an axis"""
Scale = Annotated[list[T], Field(min_length=LEVELS, max_length=LEVELS)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ScalesConfig:
    """Levels 1 to 10, from easy to hard, of the axes that are no terrain."""

    friction: Scale[Positive[Factor]]
    """of the feet on the ground"""
    payload: Scale[Positive[Kilograms]]
    """on the base"""
    delay: Scale[Positive[Seconds]]
    """in place of that of ``disturbance``; multiples of env.physics.timestep"""
    motor_strength: Scale[Positive[Factor]]
    """achieved over demanded torque of every motor"""
    sensor_noise: Scale[Positive[Factor]]
    """on env.onboard.sensors, and for controllers with the true state on ``sensing``"""
    push: Scale[Positive[NewtonSeconds]]
    """impulse of each push"""


TERRAINS = tuple(kind for kind in get_args(TerrainKind) if kind != "flat")
AXES = (*TERRAINS, *(item.name for item in fields(ScalesConfig)))
FALLING = ("friction", "motor_strength")
"""Axes that get harder with less."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class GaugeProtocol:
    """What all axes share. The robots of a level: ``trials`` × ``speeds`` × ``robots``."""

    speeds: Distinct[Some[Positive[MetresPerSecond]]]
    """commanded forward velocities"""
    trials: Annotated[Count, Field(le=100_000)]
    """each with a seed of its own"""
    robots: Count
    """per trial and speed, each with its own start; the starts of all speeds are the same"""
    seed: Seed
    """of the first trial"""
    duration: Positive[Seconds]
    """of a rollout"""
    distance: Share
    """of speed × duration, which a robot must cover to pass; 0: it must not go back"""
    start: StartNoise
    disturbance: DisturbanceConfig
    """of every robot, but for what its axis changes"""
    sensing: SensingConfig
    """white noise of level × 1 of ``sensor_noise``, for controllers with the true state"""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class GaugeConfig(GaugeProtocol):
    """Controllers, axes and levels."""

    controllers: Distinct[Some[Name]]
    """as in ``evaluation``, or NAME or NAME_onboard of ``policies``"""
    policies: dict[str, Name] = field(default_factory=dict)
    """folders of exported policies: policy.onnx, policy.json, reference.npy"""
    axes: Distinct[Some[Name]]
    """kinds of terrain, whose level is that of the terrain, and names of ``scales``"""
    levels: Annotated[Count, Field(le=LEVELS)]
    """how many of an axis are tested, from level 1 on"""
    scales: ScalesConfig
    directions: Annotated[Count, Field(le=360)]
    """of pushes, evenly about the robot, from forward towards left"""
    survival: Annotated[Share, Field(gt=0)]
    """share of robots that must pass a level"""

    def values(self, axis: str) -> list[float]:
        """Values of the tested levels, in SI units; those of terrain are its levels."""
        terrain = axis in TERRAINS
        values = range(1, LEVELS + 1) if terrain else getattr(self.scales, axis)
        return [float(value) for value in values][: self.levels]
