"""Typed settings of the gait optimisation, the gait library and the checks of its gaits."""

from dataclasses import field
from math import floor, prod
from typing import Annotated, Literal

from pydantic import Field

from slider.config import types as t

MAX_GRID = 5000  # velocities


class Axis(t.Group):
    """Values start, start + step, …, up to and including stop."""

    start: t.MetresPerSecond
    stop: t.MetresPerSecond
    step: t.Positive[t.MetresPerSecond]


_Range = Annotated[Axis, t.ordered("start", "stop")]


def axis_size(axis: Axis | list[float]) -> int:
    """Number of values of an axis; ``stop`` is included if the steps reach it within 1e-6."""
    if isinstance(axis, list):
        return len(axis)
    return floor((axis.stop - axis.start) / axis.step + 1e-6) + 1


class GridBlock(t.Group):
    """A block of velocities; an axis may be a list of values."""

    vx: _Range | t.Distinct[t.Some[t.MetresPerSecond]]
    """commanded forward velocities"""
    vy: _Range | t.Distinct[t.Some[t.MetresPerSecond]]
    """commanded leftward velocities"""
    yaw_rate: t.Distinct[t.Some[t.RadiansPerSecond]] = field(default_factory=lambda: [0.0])
    """commanded yaw rates"""

    @property
    def axes(self) -> tuple[Axis | list[float], ...]:
        """vx, vy and yaw rate."""
        return self.vx, self.vy, self.yaw_rate


class GridConfig(GridBlock):
    """The velocities of the library: one block, and optional further ones."""

    extra: list[GridBlock] = field(default_factory=list)
    """further blocks"""

    def __post_init__(self) -> None:
        size = sum(prod(map(axis_size, block.axes)) for block in (self, *self.extra))
        t.require(size <= MAX_GRID, "", f"at most {MAX_GRID} velocities", size)


class Touchdown(t.Group):
    """Velocity of the swing foot just before impact."""

    forward: t.NonNegative[t.MetresPerSecond]
    """bound of |vx|"""
    lateral: t.NonNegative[t.MetresPerSecond]
    """bound of |vy|"""
    down_min: t.NonNegative[t.MetresPerSecond]
    """minimum downward speed"""
    down_max: t.NonNegative[t.MetresPerSecond]
    """maximum downward speed"""
    angular: t.NonNegative[t.RadiansPerSecond]
    """bound of each component of the angular velocity"""


class Posture(t.Group):
    """Geometric limits of a gait."""

    clearance: t.NonNegative[t.Metres]
    """minimum clearance of the swing foot at mid-step; a parabola over the step"""
    clearance_margin: t.NonNegative[t.Metres]
    """added to the clearance at the nodes, since the foot can be lower between them"""
    clearance_from: Annotated[t.Share, t.Unit("fraction of step"), Field(lt=0.5)]
    """the clearance holds from this phase to 1 − this; outside, the foot must only not scuff"""
    swing_height: t.Positive[t.Metres]
    """maximum height of the swing foot"""
    foot_separation_min: t.NonNegative[t.Metres]
    """minimum lateral distance between the feet"""
    foot_separation_max: t.Positive[t.Metres]
    """maximum lateral distance between the feet"""
    legs_apart: t.NonNegative[t.Metres]
    """minimum distance between the feet, and between the tubes' upper ends, along the base's y"""
    torso_roll: t.NonNegative[t.Radians]
    torso_pitch: t.NonNegative[t.Radians]
    torso_yaw: t.NonNegative[t.Radians]
    torso_rate: t.NonNegative[t.RadiansPerSecond]
    """bound of each component of the angular velocity"""
    knee_min: t.NonNegative[t.Radians]
    """minimum virtual knee flexion; avoids the straight leg"""
    knee_max: t.Positive[t.Radians]
    """maximum virtual knee flexion"""


class ContactLimits(t.Group):
    """Limits of the ground reaction forces on the stance foot."""

    friction: t.Positive[t.Factor]
    """Coulomb friction coefficient that the gait may use"""
    min_vertical: Annotated[t.Share, t.Unit("fraction of weight")]
    """minimum vertical force at toe and heel"""


class SolverConfig(t.Group):
    """IPOPT settings and the initial guesses."""

    max_iterations: t.Count
    """maximum number of iterations per initial guess"""
    tolerance: t.Tolerance
    """IPOPT tol"""
    constraint_tolerance: t.Tolerance
    """IPOPT constr_viol_tol, in the scaled units of the problem"""
    guesses: t.Distinct[t.Some[Literal["cold", "fast", "crouched", "ramp"]]]
    """initial guesses, tried in order until one converges, after the gait of a nearby velocity if
    there is one; crouched: knees bent most, long steps; fast: short quick steps; cold: knees less
    bent, long steps; ramp: warm starts from walking in place"""


class StartSpread(t.Group):
    """Random initial guesses, uniform about the crouched walk and within ``gait.step_time``."""

    joints: t.Positive[t.Radians]
    """largest change of a Bézier coefficient, drawn independently per joint and step"""
    crouch: t.Interval[t.Positive[t.Radians]]
    """range of the knee flexion"""
    stride: t.Interval[t.Positive[t.Factor]]
    """range of the step length, relative to that of the commanded velocity"""


Nodes = t.Odd[Annotated[int, Field(ge=5, le=201)]]


class FormulationConfig(t.Group):
    """The optimisation problem, equal for all velocities; see ``docs/explanation/method.md``."""

    nodes: Nodes
    """collocation nodes per step"""
    degree: Annotated[int, Field(ge=3, le=12)]
    """degree of the virtual constraints: Bézier polynomials of the joints over the phase"""
    dynamics: Literal["prismatic", "knee"]
    """bodies of the model: those of the real leg and its rotors, or of the virtual knee"""
    cost: Literal["paper", "transport"]
    """paper: eq. 2 as read in docs/paper.md; transport: mean |power| / (m g)"""
    voltage: t.Positive[t.Share]
    """share of the bus voltage available to motors at the nodes; the rest is margin between them"""
    touchdown: Annotated[Touchdown, t.ordered("down_min", "down_max")]
    posture: Annotated[
        Posture,
        t.ordered("knee_min", "knee_max"),
        t.ordered("foot_separation_min", "foot_separation_max"),
        t.Rule(
            "clearance + clearance_margin < swing_height",
            lambda posture: posture.clearance + posture.clearance_margin < posture.swing_height,
            ("clearance", "clearance_margin", "swing_height"),
        ),
    ]
    contact: ContactLimits
    bounds: dict[str, t.Interval[t.Number]]
    """bounds of further constraints at every node, by name in ``slider.gait.constraints``; SI"""


class SolveConfig(t.Group):
    """How a gait is found and converted."""

    kinematic_map: Literal["exact", "paper"]
    """map from knee to slide (eq. 1): exact geometry, or the matrix as printed in the paper"""
    decoupling_min: Annotated[float, t.Unit("rad/s² | m/s²"), Field(ge=0, le=1e4)]
    """minimum singular value of the decoupling matrix, for inputs as shares of torque limits"""
    step_time: t.Interval[t.Positive[t.Seconds]]
    """bounds of the step duration"""
    solver: SolverConfig


class GaitConfig(SolveConfig, FormulationConfig):
    """One gait per velocity of the grid."""

    grid: GridConfig


class LibraryConfig(t.Group):
    """How gaits are collected."""

    allow_holes: bool
    """false: the library fails, with a list of gaits, if any gait did not converge"""
    max_violation: Annotated[t.Tolerance, t.Unit("SI")]
    """maximum constraint violation up to which a gait counts as converged"""


class IntegratorConfig(t.Group):
    """Tolerances of DOP853."""

    relative: t.Tolerance
    absolute: Annotated[t.Tolerance, t.Unit("rad, rad/s")]


class CheckConfig(t.Group):
    """Settings for the checks of a single gait."""

    integrator: IntegratorConfig
    points: Annotated[t.Count, Field(ge=2)]
    """sample points per step, at which constraints are checked between nodes"""


class VerificationConfig(CheckConfig):
    """All settings of the verification."""

    chunk: t.Count
    """gaits per job"""
    on_failure: Literal["error", "report"]
    """report: a violated bound is only reported; error: it makes the verification job fail"""
    bounds: dict[str, Annotated[t.NonNegative[t.Number], t.Unit("of the quantity")] | None]
    """bound of the quantity, see docs/reference/verification.md; null: reported only"""
