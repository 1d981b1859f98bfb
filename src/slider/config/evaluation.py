"""Typed settings of evaluations: protocols, seeds, gauge, search for settings, report.

See ``docs/how-to/gauge.md`` and ``docs/explanation/baseline.md``.
"""

from dataclasses import field, fields
from itertools import pairwise
from typing import Annotated, Literal, get_args

from pydantic import AfterValidator, Field

from slider.config import types as t
from slider.config.env import (
    ControlTime,
    DisturbanceConfig,
    Level,
    PhysicsTime,
    SensingConfig,
    StartNoise,
    TerrainKind,
)
from slider.core.quantities import speed_text


class SpeedsConfig(t.Group):
    """Commanded forward velocities that several parts of the configuration share."""

    table1: t.Distinct[t.Some[t.MetresPerSecond]]
    """of Table 1"""
    top: t.Positive[t.MetresPerSecond]
    """the highest one, of gaits, trainings and the viewer"""


class Segment(t.Group):
    """A constant velocity, until the next segment."""

    name: t.Name
    time: t.Seconds
    """from when on"""
    vx: t.MetresPerSecond
    vy: t.MetresPerSecond = 0.0
    yaw_rate: t.RadiansPerSecond = 0.0


_NAMED_ONCE = t.Rule("each name once", lambda items: len({i.name for i in items}) == len(items))
_Segments = Annotated[
    t.Some[Segment],
    _NAMED_ONCE,
    t.Rule(
        "times that rise from 0 s",
        lambda items: items[0].time == 0 and all(a.time < b.time for a, b in pairwise(items)),
    ),
]


class CaseConfig(t.Group):
    """One rollout: its segments in the order of time, the first one from 0 s on."""

    name: t.Name
    segments: _Segments


def at_speed(speed: float) -> CaseConfig:
    """A constant forward velocity [m/s]."""
    return CaseConfig(f"{speed_text(speed)} m/s", [Segment("walk", 0.0, speed)])


class ProfileConfig(t.Group):
    """Velocities that change during a rollout; see ``docs/how-to/evaluate.md``.

    ``rows`` and ``cases`` are not in the section of a single evaluation, which has its own case.
    """

    ramp: t.Seconds
    """duration of the change from a segment's velocity to the next one's; 0: a step"""
    warm_up: t.Seconds
    """start of each segment that does not count for its errors"""
    window: t.Positive[t.Seconds]
    """moving average over which velocities are drawn"""
    rows: Literal["segments", "cases"] = "segments"
    """of the report's table: segments of the only case, or cases, each by its last segment"""
    cases: Annotated[t.Some[CaseConfig], _NAMED_ONCE] = field(default_factory=list)
    """rollouts: from a time on, vx, vy and yaw_rate, 0 if not said"""

    def __post_init__(self) -> None:
        names = [case.name for case in self.cases]
        possible = self.rows == "cases" or len(names) <= 1
        t.require(possible, "cases", "one case where rows are its segments", names)


def _without_curriculum(disturbance: DisturbanceConfig) -> DisturbanceConfig:
    possible = not disturbance.terrain.curriculum
    t.require(possible, "terrain.curriculum", "false outside trainings", "true")
    return disturbance


_Disturbance = Annotated[DisturbanceConfig, AfterValidator(_without_curriculum)]


class EvaluationConfig(t.Group):
    """A protocol: every controller, velocity, trial and robot; see ``docs/explanation/method.md``.

    ``controllers`` and ``speeds`` say which evaluations there are; they are not in the section
    of a single one, which would otherwise be redone with every new speed. A protocol has either
    ``speeds``, constant forward velocities, or a ``profile``.
    """

    trials: Annotated[t.Count, Field(le=100_000)]
    """trials, each with a seed of its own"""
    robots: t.Count
    """per trial, each with its own start"""
    duration: t.Positive[t.Seconds]
    """of a rollout"""
    warm_up: t.Seconds
    """start of mse_steady and of the tracked mean velocity"""
    tracking_tolerance: t.NonNegative[t.MetresPerSecond]
    """tracked: |mean v − speed| ≤ max(this, tracking_relative · speed)"""
    tracking_relative: t.Factor
    """the same relative to the commanded speed"""
    seed: t.Seed
    """of the first trial"""
    start: StartNoise
    disturbance: _Disturbance
    controllers: t.Distinct[t.Some[t.Name]] = field(default_factory=list)
    """rows of the table"""
    speeds: t.Distinct[list[t.MetresPerSecond]] = field(default_factory=list)
    """constant forward velocities; none with a profile"""
    profile: ProfileConfig | None = None
    """velocities that change; null: constant ones"""

    def __post_init__(self) -> None:
        possible = not (self.speeds and self.profile)
        t.require(possible, "speeds", "none with a profile", self.speeds)

    @property
    def cases(self) -> list[CaseConfig]:
        """Rollouts of each controller."""
        return self.profile.cases if self.profile else list(map(at_speed, self.speeds))


class SeedBlock(t.Group):
    """Consecutive seeds, ``first`` and ``last`` included."""

    first: t.Seed
    last: t.Seed

    def __contains__(self, seed: int) -> bool:
        return self.first <= seed <= self.last

    def __str__(self) -> str:
        return f"{self.first} to {self.last}"


class SeedsConfig(t.Group):
    """Blocks of seeds that are held apart: nothing is chosen by results from ``final``.

    Trial k of an evaluation draws its starts from its seed + k.
    """

    final: Annotated[SeedBlock, t.ordered("first", "last")]
    development: Annotated[SeedBlock, t.ordered("first", "last")]
    selection: t.Seed
    """of development: the checks that pick a training's checkpoint"""

    def __post_init__(self) -> None:
        final, other = self.final, self.development
        apart = final.last < other.first or other.last < final.first
        t.require(apart, "final", f"no seed of seeds.development ({other})", final)


LEVELS = 10
"""of an axis"""
Scale = Annotated[list[t.T], Field(min_length=LEVELS, max_length=LEVELS)]


class ScalesConfig(t.Group, kw_only=True):
    """Levels 1 to 10, from easy to hard, of the axes that are no terrain."""

    friction: t.Falling[Scale[t.Positive[t.Factor]]]
    """of the feet on the ground"""
    payload: t.Rising[Scale[t.Positive[t.Kilograms]]]
    """on the base"""
    delay: t.Rising[Scale[t.Positive[PhysicsTime]]]
    """in place of that of ``disturbance``"""
    motor_strength: t.Falling[Scale[t.Positive[t.Factor]]]
    """achieved over demanded torque of every motor"""
    sensor_noise: t.Rising[Scale[t.Positive[t.Factor]]]
    """on env.onboard.sensors, and for controllers with the true state on ``sensing``"""
    push: t.Rising[Scale[t.Positive[t.NewtonSeconds]]]
    """impulse of each push"""


TERRAINS = tuple(kind for kind in get_args(TerrainKind) if kind != "flat")
AXES = (*TERRAINS, *(item.name for item in fields(ScalesConfig)))


class GaugeProtocol(t.Group, kw_only=True):
    """What all axes share. The robots of a level: ``trials`` × ``speeds`` × ``robots``."""

    speeds: t.Distinct[t.Some[t.Positive[t.MetresPerSecond]]]
    """commanded forward velocities"""
    trials: Annotated[t.Count, Field(le=100_000)]
    """each with a seed of its own"""
    robots: t.Count
    """per trial and speed, each with its own start; the starts of all speeds are the same"""
    seed: t.Seed
    """of the first trial"""
    duration: ControlTime
    """of a rollout"""
    distance: t.Share
    """of speed × duration, which a robot must cover to pass; 0: it must not go back"""
    start: StartNoise
    disturbance: _Disturbance
    """of every robot, but for what its axis changes"""
    sensing: SensingConfig
    """white noise of level × 1 of ``sensor_noise``, for controllers with the true state"""


class GaugeConfig(GaugeProtocol, kw_only=True):
    """Controllers, axes and levels."""

    controllers: t.Distinct[t.Some[t.Name]]
    """as in ``evaluation``, or NAME or NAME_onboard of ``policies``"""
    policies: t.Named[t.Name] = field(default_factory=dict)
    """folders of exported policies: policy.onnx, policy.json"""
    axes: t.Distinct[t.Some[t.Name]]
    """kinds of terrain, whose level is that of the terrain, and names of ``scales``"""
    levels: Annotated[t.Count, Field(le=LEVELS)]
    """how many of an axis are tested, from level 1 on"""
    scales: ScalesConfig
    directions: Annotated[t.Count, Field(le=360)]
    """of pushes, evenly about the robot, from forward towards left"""
    survival: Annotated[t.Share, Field(gt=0)]
    """share of robots that must pass a level"""

    def __post_init__(self) -> None:
        for axis in self.axes:
            t.require(axis in AXES, "axes", f"one of {', '.join(AXES)}", axis)
        least = self.disturbance.push.interval + self.disturbance.push.duration
        possible = "push" not in self.axes or self.duration >= least
        t.require(possible, "duration", f"at least {least:g} s, with a push", self.duration)

    def values(self, axis: str) -> list[float]:
        """Values of the tested levels, in SI units; those of terrain are its levels."""
        terrain = axis in TERRAINS
        values = range(1, LEVELS + 1) if terrain else getattr(self.scales, axis)
        return [float(value) for value in values][: self.levels]


class DrakeContact(t.Group):
    """Point contact in Drake; what is not here is Drake's default."""

    approximation: Literal["lagged", "similar", "sap"]
    """of its solver SAP"""
    dissipation: t.Positive[t.SecondsPerMetre] | None = None
    """of Hunt and Crossley, of both bodies; null is Drake's default, of which sap has none"""

    def __post_init__(self) -> None:
        unused = self.approximation == "sap" and self.dissipation is not None
        t.require(not unused, "dissipation", "null with approximation=sap", self.dissipation)

    @property
    def label(self) -> str:
        """Name in tables."""
        return self.approximation + ("" if (d := self.dissipation) is None else f", {d:g} s/m")


class SecondEngineConfig(t.Group):
    """Drake beside MuJoCo: a protocol on both, and the policy on floors of less friction."""

    protocol: EvaluationConfig
    """on both engines, from the same starts"""
    timestep: t.Positive[t.Seconds]
    """of Drake; a divisor of env.physics.timestep"""
    contacts: t.Some[DrakeContact]
    """of Drake"""
    frictions: t.Falling[t.Some[t.Positive[t.Factor]]]
    """of feet and floor, in place of robot.contact.friction, until the robots fall"""
    friction_controllers: t.Distinct[t.Some[t.Name]]
    """of ``protocol``, those that walk on these"""
    friction_speed: t.Positive[t.MetresPerSecond]
    """commanded forward velocity there"""

    def __post_init__(self) -> None:
        constant = self.protocol.profile is None
        t.require(constant, "protocol.profile", "null: constant speeds", "a profile")
        labels = [contact.label for contact in self.contacts]
        t.require(len({*labels}) == len(labels), "contacts", "each once", "; ".join(labels))


class RangeConfig(t.Group):
    """What a setting is drawn from; the present value belongs to it."""

    lower: t.Number
    """least value"""
    upper: t.Number
    """greatest value"""
    log: bool = False
    """uniform in the logarithm"""


_Range = Annotated[
    RangeConfig,
    t.ordered("lower", "upper"),
    t.Rule("lower > 0 with log", lambda bounds: bounds.lower > 0 or not bounds.log),
]


class TuningConfig(t.Group, kw_only=True):
    """A search for each controller of ``spaces``."""

    trials: t.Count
    """sets of settings that are simulated; the first one is the present one"""
    sampler_seed: t.Seed
    """of the draws"""
    speeds: t.Distinct[t.Some[t.Positive[t.MetresPerSecond]]]
    """commanded forward velocities, of one score"""
    robots: t.Count
    """per speed, each with its own start; the same in all trials"""
    finalists: t.Count
    """best trials that are measured again, as the present settings are"""
    finalist_robots: t.Count
    """per speed"""
    seed: t.Seed
    """of the starts; the finalists' is the next one"""
    spaces: dict[str, dict[str, _Range]]
    """controller of ``control``, or NAME_onboard → dotted name of a number of it → range"""


Pixels = t.Even[Annotated[int, Field(ge=32, le=1920)]]
"""H.264 stores colours at half the resolution."""


class FilmedTerrain(t.Group):
    """Videos of the policy on terrain, with onboard state."""

    kinds: t.Distinct[list[TerrainKind]]
    """one video for each"""
    level: Level
    """of all of them"""
    speed: t.MetresPerSecond
    """commanded forward velocity"""


class VideoConfig(t.Group):
    """Which videos are made, and how; the section of a single one has no lists of them."""

    renderer: Literal["auto", "egl", "osmesa", "none"]
    """none: a page without videos; auto: the first that works"""
    camera: Literal["side", "front", "both"]
    """where they are filmed from; both: two pictures next to each other"""
    duration: t.Positive[t.Seconds]
    """from rest"""
    width: Pixels
    """of a picture, in pixels"""
    height: Pixels
    """of a picture, in pixels"""
    frame_rate: Annotated[t.Count, Field(le=1000)]
    """frames per second; must divide the control rate"""
    quality: Annotated[int, Field(ge=0, le=51)]
    """constant rate factor of H.264, 0 (lossless, large) to 51"""
    seed: t.Seed
    """of the start's noise"""
    speeds: t.Distinct[list[t.MetresPerSecond]] = field(default_factory=list)
    """one video per controller and speed"""
    terrain: FilmedTerrain | None = None
    """videos on ground that is not flat; null: none"""

    @property
    def cameras(self) -> tuple[str, ...]:
        """From left to right in a picture."""
        return ("side", "front") if self.camera == "both" else (self.camera,)


class ReportConfig(t.Group):
    """The page reports/index.html and the videos in it."""

    sections: t.Distinct[t.Some[t.Name]]
    """of the page, in order"""
    tracking_speeds: t.Distinct[list[t.MetresPerSecond]]
    """velocity tracking is drawn for these, where evaluated"""
    video: VideoConfig
