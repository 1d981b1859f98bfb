"""Typed settings of evaluations: protocols and their seeds, the gauge, the search for settings.

See ``docs/how-to/gauge.md`` and ``docs/explanation/baseline.md``.
"""

import copy
from collections.abc import Mapping
from dataclasses import field, fields
from itertools import pairwise
from typing import Annotated, Any, Literal, get_args

from pydantic import Field
from pydantic.dataclasses import dataclass

from slider.config.env import DisturbanceConfig, SensingConfig, StartNoise, TerrainKind
from slider.config.types import (
    STRICT,
    Count,
    Distinct,
    Factor,
    Falling,
    Kilograms,
    MetresPerSecond,
    Name,
    NewtonSeconds,
    NonNegative,
    Number,
    Positive,
    RadiansPerSecond,
    Rising,
    Rule,
    Seconds,
    Seed,
    Share,
    Some,
    T,
    ordered,
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


_NAMED_ONCE = Rule("each name once", lambda items: len({i.name for i in items}) == len(items))
_Segments = Annotated[
    Some[Segment],
    _NAMED_ONCE,
    Rule(
        "times that rise from 0 s",
        lambda items: items[0].time == 0 and all(a.time < b.time for a, b in pairwise(items)),
    ),
]


@dataclass(frozen=True, config=STRICT)
class CaseConfig:
    """One rollout: its segments in the order of time, the first one from 0 s on."""

    name: Name
    segments: _Segments


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
    cases: Annotated[Some[CaseConfig], _NAMED_ONCE] = field(default_factory=list)
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

    final: Annotated[SeedBlock, ordered("first", "last")]
    development: Annotated[SeedBlock, ordered("first", "last")]
    selection: Seed
    """of development: the checks that pick a training's checkpoint"""


LEVELS = 10
"""of an axis"""
Scale = Annotated[list[T], Field(min_length=LEVELS, max_length=LEVELS)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ScalesConfig:
    """Levels 1 to 10, from easy to hard, of the axes that are no terrain."""

    friction: Falling[Scale[Positive[Factor]]]
    """of the feet on the ground"""
    payload: Rising[Scale[Positive[Kilograms]]]
    """on the base"""
    delay: Rising[Scale[Positive[Seconds]]]
    """in place of that of ``disturbance``; multiples of env.physics.timestep"""
    motor_strength: Falling[Scale[Positive[Factor]]]
    """achieved over demanded torque of every motor"""
    sensor_noise: Rising[Scale[Positive[Factor]]]
    """on env.onboard.sensors, and for controllers with the true state on ``sensing``"""
    push: Rising[Scale[Positive[NewtonSeconds]]]
    """impulse of each push"""


TERRAINS = tuple(kind for kind in get_args(TerrainKind) if kind != "flat")
AXES = (*TERRAINS, *(item.name for item in fields(ScalesConfig)))


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


@dataclass(frozen=True, config=STRICT)
class RangeConfig:
    """What a setting is drawn from; the present value belongs to it."""

    lower: Number
    """least value"""
    upper: Number
    """greatest value"""
    log: bool = False
    """uniform in the logarithm"""


_Range = Annotated[
    RangeConfig,
    ordered("lower", "upper"),
    Rule("lower > 0 with log", lambda bounds: bounds.lower > 0 or not bounds.log),
]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class TuningConfig:
    """A search for each controller of ``spaces``."""

    trials: Count
    """sets of settings that are simulated; the first one is the present one"""
    sampler_seed: Seed
    """of the draws"""
    speeds: Distinct[Some[Positive[MetresPerSecond]]]
    """commanded forward velocities, of one score"""
    robots: Count
    """per speed, each with its own start; the same in all trials"""
    seed: Seed
    """of the starts"""
    spaces: dict[str, dict[str, _Range]]
    """controller of ``control``, or NAME_onboard → dotted name of a number of it → range"""


def setting(control: Mapping[str, Any], name: str) -> float | None:
    """The number at a dotted name of a controller's settings, None without one."""
    value: Any = control
    for part in name.split("."):
        value = value.get(part) if isinstance(value, Mapping) else None
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return value if number else None


def with_settings(control: Mapping[str, Any], settings: Mapping[str, float]) -> dict[str, Any]:
    """A controller's settings with other numbers at dotted names that there are."""
    changed = copy.deepcopy(dict(control))
    for name, value in settings.items():
        *groups, last = name.split(".")
        place = changed
        for group in groups:
            place = place[group]
        place[last] = value
    return changed
