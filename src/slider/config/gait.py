"""Typed settings of the gait optimisation and of the gait library."""

import math
from dataclasses import field

from pydantic.dataclasses import dataclass

from slider.config.strict import STRICT


@dataclass(frozen=True, config=STRICT)
class Axis:
    """start, start + step, ... up to and including stop [m/s]."""

    start: float
    stop: float
    step: float


def axis_size(axis: Axis | list[float]) -> int:
    """Number of values of an axis; the stop counts when the steps reach it within 1e-6."""
    if isinstance(axis, list):
        return len(axis)
    if axis.step <= 0 or axis.stop < axis.start:
        return 0
    return math.floor((axis.stop - axis.start) / axis.step + 1e-6) + 1


@dataclass(frozen=True, config=STRICT)
class GridBlock:
    """A rectangle of commanded velocities [m/s]; an axis may be a list of values."""

    vx: Axis | list[float]
    vy: Axis | list[float]


@dataclass(frozen=True, config=STRICT)
class GridConfig:
    """The commanded velocities of the library: one rectangle, and further ones beside it."""

    vx: Axis | list[float]
    vy: Axis | list[float]
    extra: list[GridBlock] = field(default_factory=list)


@dataclass(frozen=True, config=STRICT)
class StepTime:
    """Duration of a step [s].

    ``law``: ``free`` within the bounds; ``fixed`` at ``value``; ``speed``: value + slope · speed,
    within the bounds, ``slope`` in s per m/s.
    """

    lower: float
    upper: float
    law: str
    value: float
    slope: float


@dataclass(frozen=True, config=STRICT)
class Touchdown:
    """Velocity of the swing foot just before impact: [m/s], angular rate [rad/s]."""

    forward: float
    lateral: float
    down_min: float
    down_max: float
    angular: float


@dataclass(frozen=True, config=STRICT)
class Posture:
    """Geometric limits of a gait: [m], [rad]."""

    clearance: float
    clearance_margin: float
    swing_height: float
    foot_separation_min: float
    foot_separation_max: float
    legs_apart: float
    torso_roll: float
    torso_pitch: float
    torso_yaw: float
    torso_rate: float
    knee_min: float
    knee_max: float


@dataclass(frozen=True, config=STRICT)
class ContactLimits:
    """Friction coefficient [-], least vertical force at toe and heel [fraction of weight]."""

    friction: float
    min_vertical: float


@dataclass(frozen=True, config=STRICT)
class SolverConfig:
    """IPOPT settings, what is tried in turn, and whether the first or the best result counts."""

    max_iterations: int
    tolerance: float
    constraint_tolerance: float
    guesses: list[str]
    keep: str


@dataclass(frozen=True, config=STRICT)
class FormulationConfig:
    """What a gait is, the same for all commanded velocities; see ``docs/explanation/method.md``.

    ``voltage``: share of the bus that motors may use at the nodes; the rest is for between them.
    """

    nodes: int
    transcription: str
    degree: int
    dynamics: str
    cost: str
    voltage: float
    touchdown: Touchdown
    posture: Posture
    contact: ContactLimits


@dataclass(frozen=True, config=STRICT)
class SolveConfig:
    """How a gait is found and converted."""

    kinematic_map: str
    step_time: StepTime
    solver: SolverConfig


@dataclass(frozen=True, config=STRICT)
class GaitConfig(SolveConfig, FormulationConfig):
    """One gait per velocity of the grid."""

    grid: GridConfig


@dataclass(frozen=True, config=STRICT)
class LibraryConfig:
    """How gaits are collected."""

    allow_holes: bool
    max_violation: float
