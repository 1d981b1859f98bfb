"""Typed settings of evaluations: protocols, seeds, gauge, hyperparameter search, report.

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
    """commanded forward velocities of Table 1"""
    top: t.Positive[t.MetresPerSecond]
    """highest forward velocity of gaits, trainings and the viewer"""


class Segment(t.Group):
    """Constant commanded velocity until the next segment starts."""

    name: t.Name
    time: t.Seconds
    """start of the segment"""
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
    """One rollout: its segments in chronological order, the first starting at 0 s."""

    name: t.Name
    segments: _Segments


def at_speed(speed: float) -> CaseConfig:
    """Case with a constant forward velocity [m/s]."""
    return CaseConfig(f"{speed_text(speed)} m/s", [Segment("walk", 0.0, speed)])


class ProfileConfig(t.Group):
    """Velocities that change during a rollout; see ``docs/how-to/evaluate.md``.

    ``rows`` and ``cases`` are not in the section of a single evaluation, which has its own case.
    """

    ramp: t.Seconds
    """duration of the ramp from a segment's velocity to the next one's; 0: a step change"""
    warm_up: t.Seconds
    """initial part of each segment that is excluded from its errors"""
    window: t.Positive[t.Seconds]
    """length of the moving average in velocity plots"""
    rows: Literal["segments", "cases"] = "segments"
    """rows of the report's table: segments of the only case, or the last segment of each case"""
    cases: Annotated[t.Some[CaseConfig], _NAMED_ONCE] = field(default_factory=list)
    """rollouts; each segment has a start time, vx, and optionally vy and yaw_rate (default 0)"""

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
    """A protocol: controllers × velocities × trials × robots; see ``docs/explanation/method.md``.

    ``controllers`` and ``speeds`` define the list of evaluations; they are not part of the section
    of a single one, so that a new speed does not recompute the others. A protocol has either
    ``speeds``, constant forward velocities, or a ``profile``.
    """

    trials: Annotated[t.Count, Field(le=100_000)]
    """number of trials, each with its own seed"""
    robots: t.Count
    """robots per trial, each with its own initial state"""
    duration: t.Positive[t.Seconds]
    """duration of a rollout"""
    warm_up: t.Seconds
    """time from which mse_steady and the mean velocity (see tracking_tolerance) are computed"""
    tracking_tolerance: t.NonNegative[t.MetresPerSecond]
    """a robot tracks if |mean v − speed| ≤ max(tracking_tolerance, tracking_relative · speed)"""
    tracking_relative: t.Factor
    """tolerance relative to the commanded speed; see tracking_tolerance"""
    seed: t.Seed
    """seed of the first trial"""
    start: StartNoise
    disturbance: _Disturbance
    controllers: t.Distinct[t.Some[t.Name]] = field(default_factory=list)
    """rows of the table"""
    speeds: t.Distinct[list[t.MetresPerSecond]] = field(default_factory=list)
    """constant forward velocities; none with a profile"""
    profile: ProfileConfig | None = None
    """commanded velocities that change over time; null: constant ``speeds``"""

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
    """Disjoint blocks of seeds: no choice is based on results with seeds from ``final``.

    Trial k of an evaluation draws its starts from its seed + k.
    """

    final: Annotated[SeedBlock, t.ordered("first", "last")]
    development: Annotated[SeedBlock, t.ordered("first", "last")]
    selection: t.Seed
    """seed, from the development block, of the checks that pick a training's checkpoint"""

    def __post_init__(self) -> None:
        final, other = self.final, self.development
        apart = final.last < other.first or other.last < final.first
        t.require(apart, "final", f"no seed of seeds.development ({other})", final)


LEVELS = 10
"""Number of levels of an axis."""
Scale = Annotated[list[t.T], Field(min_length=LEVELS, max_length=LEVELS)]


class ScalesConfig(t.Group, kw_only=True):
    """Values of levels 1 to 10, from easy to hard, of the axes other than terrain."""

    friction: t.Falling[Scale[t.Positive[t.Factor]]]
    """friction coefficient of the feet on the ground"""
    payload: t.Rising[Scale[t.Positive[t.Kilograms]]]
    """mass added to the base"""
    delay: t.Rising[Scale[t.Positive[PhysicsTime]]]
    """actuation delay, instead of disturbance.delay"""
    motor_strength: t.Falling[Scale[t.Positive[t.Factor]]]
    """ratio of achieved to commanded torque of every motor"""
    sensor_noise: t.Rising[Scale[t.Positive[t.Factor]]]
    """factor on env.onboard.sensors, or on ``sensing`` for controllers that get the true state"""
    push: t.Rising[Scale[t.Positive[t.NewtonSeconds]]]
    """impulse of each push"""


TERRAINS = tuple(kind for kind in get_args(TerrainKind) if kind != "flat")
AXES = (*TERRAINS, *(item.name for item in fields(ScalesConfig)))


class GaugeProtocol(t.Group, kw_only=True):
    """Settings shared by all axes. A level has ``trials`` × ``speeds`` × ``robots`` robots."""

    speeds: t.Distinct[t.Some[t.Positive[t.MetresPerSecond]]]
    """commanded forward velocities"""
    trials: Annotated[t.Count, Field(le=100_000)]
    """number of trials, each with its own seed"""
    robots: t.Count
    """robots per trial and speed, each with its own initial state; all speeds share these states"""
    seed: t.Seed
    """seed of the first trial"""
    duration: ControlTime
    """duration of a rollout"""
    distance: t.Share
    """share of speed × duration that a robot must cover to pass; 0: it must not move backwards"""
    start: StartNoise
    disturbance: _Disturbance
    """disturbance of every robot, apart from the quantity that the axis varies"""
    sensing: SensingConfig
    """white noise at a ``sensor_noise`` of 1, for controllers that get the true state"""


class GaugeConfig(GaugeProtocol, kw_only=True):
    """Controllers, axes and levels."""

    controllers: t.Distinct[t.Some[t.Name]]
    """as in ``evaluation``, or NAME or NAME_onboard for a NAME of ``policies``"""
    policies: t.Named[t.Name] = field(default_factory=dict)
    """folders of exported policies, each with policy.onnx and policy.json"""
    axes: t.Distinct[t.Some[t.Name]]
    """kinds of terrain, with their terrain levels, and names of ``scales``"""
    levels: Annotated[t.Count, Field(le=LEVELS)]
    """number of levels tested per axis, starting with level 1"""
    scales: ScalesConfig
    directions: Annotated[t.Count, Field(le=360)]
    """number of push directions, evenly spaced, counted from forward towards left"""
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
    """Point contact in Drake; all other contact parameters keep Drake's defaults."""

    approximation: Literal["lagged", "similar", "sap"]
    """contact approximation of the SAP solver"""
    dissipation: t.Positive[t.SecondsPerMetre] | None = None
    """Hunt-Crossley dissipation of both bodies; null: Drake's default; must be null with sap"""

    def __post_init__(self) -> None:
        unused = self.approximation == "sap" and self.dissipation is not None
        t.require(not unused, "dissipation", "null with approximation=sap", self.dissipation)

    @property
    def label(self) -> str:
        """Name in tables."""
        return self.approximation + ("" if (d := self.dissipation) is None else f", {d:g} s/m")


class SecondEngineConfig(t.Group):
    """Comparison of Drake and MuJoCo: a protocol on both, and rollouts with other frictions."""

    protocol: EvaluationConfig
    """protocol evaluated on both engines, from the same initial states"""
    timestep: t.Positive[t.Seconds]
    """time step of Drake; must divide env.physics.timestep"""
    contacts: t.Some[DrakeContact]
    """contact models of Drake to compare"""
    frictions: t.Falling[t.Some[t.Positive[t.Factor]]]
    """coefficients of feet and floor, instead of robot.contact.friction, in falling order"""
    friction_controllers: t.Distinct[t.Some[t.Name]]
    """controllers of ``protocol`` that walk with each of ``frictions``"""
    friction_speed: t.Positive[t.MetresPerSecond]
    """commanded forward velocity with ``frictions``"""

    def __post_init__(self) -> None:
        constant = self.protocol.profile is None
        t.require(constant, "protocol.profile", "null: constant speeds", "a profile")
        labels = [contact.label for contact in self.contacts]
        t.require(len({*labels}) == len(labels), "contacts", "each once", "; ".join(labels))


class RangeConfig(t.Group):
    """Search range of a setting, widened to contain its current value."""

    lower: t.Number
    """lower bound"""
    upper: t.Number
    """upper bound"""
    log: bool = False
    """sample uniformly in the logarithm"""


_Range = Annotated[
    RangeConfig,
    t.ordered("lower", "upper"),
    t.Rule("lower > 0 with log", lambda bounds: bounds.lower > 0 or not bounds.log),
]


class TuningConfig(t.Group, kw_only=True):
    """One hyperparameter search for each controller in ``spaces``."""

    trials: t.Count
    """number of parameter sets simulated; the first is the current configuration"""
    sampler_seed: t.Seed
    """seed of the sampler"""
    speeds: t.Distinct[t.Some[t.Positive[t.MetresPerSecond]]]
    """commanded forward velocities, combined into one score"""
    robots: t.Count
    """robots per speed, each with its own initial state; the same states in all trials"""
    finalists: t.Count
    """number of best trials that are measured again, together with the current configuration"""
    finalist_robots: t.Count
    """robots per speed when finalists are measured again"""
    seed: t.Seed
    """seed of the initial states; finalists use seed + 1"""
    spaces: dict[str, dict[str, _Range]]
    """controller of ``control``, or its NAME_onboard → dotted name of a number in it → range"""


Pixels = t.Even[Annotated[int, Field(ge=32, le=1920)]]
"""H.264 stores colours at half the resolution."""


class FilmedTerrain(t.Group):
    """Videos of the policy on terrain, with onboard state."""

    kinds: t.Distinct[list[TerrainKind]]
    """terrains to film, one video each"""
    level: Level
    """terrain level of all these videos"""
    speed: t.MetresPerSecond
    """commanded forward velocity"""


class VideoConfig(t.Group):
    """Which videos are made, and how; the section of a single video leaves out the lists."""

    renderer: Literal["auto", "egl", "osmesa", "none"]
    """none: a report without videos; auto: the first renderer that works"""
    camera: Literal["side", "front", "both"]
    """camera position; both: two views next to each other"""
    duration: t.Positive[t.Seconds]
    """length of a video, which starts at rest"""
    width: Pixels
    """width of a view, in pixels"""
    height: Pixels
    """height of a view, in pixels"""
    frame_rate: Annotated[t.Count, Field(le=1000)]
    """frames per second; must divide the control rate"""
    quality: Annotated[int, Field(ge=0, le=51)]
    """constant rate factor of H.264, 0 (lossless, large) to 51"""
    seed: t.Seed
    """seed of the noise on the initial state"""
    speeds: t.Distinct[list[t.MetresPerSecond]] = field(default_factory=list)
    """one video per controller and speed"""
    terrain: FilmedTerrain | None = None
    """videos on uneven terrain; null: none"""

    @property
    def cameras(self) -> tuple[str, ...]:
        """Cameras of a video frame, from left to right."""
        return ("side", "front") if self.camera == "both" else (self.camera,)


class ReportConfig(t.Group):
    """The page reports/index.html and the videos in it."""

    sections: t.Distinct[t.Some[t.Name]]
    """sections of the page, in order"""
    tracking_speeds: t.Distinct[list[t.MetresPerSecond]]
    """speeds for which velocity tracking is plotted, if they were evaluated"""
    video: VideoConfig
