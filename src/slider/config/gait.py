"""Typed settings of the gait optimisation, the gait library and the checks of its gaits."""

from dataclasses import field
from math import floor, prod
from typing import Annotated, Literal

from pydantic import Field

from slider.config import types as t

MAX_GRID = 5000  # velocities


class Axis(t.Group):
    """start, start + step, ... up to and including stop."""

    start: t.MetresPerSecond
    stop: t.MetresPerSecond
    step: t.Positive[t.MetresPerSecond]


_Range = Annotated[Axis, t.ordered("start", "stop")]


def axis_size(axis: Axis | list[float]) -> int:
    """Number of values of an axis; the stop counts when the steps reach it within 1e-6."""
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
    """The velocities of the library: one block, and further ones beside it."""

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
    """least downward speed"""
    down_max: t.NonNegative[t.MetresPerSecond]
    """greatest downward speed"""
    angular: t.NonNegative[t.RadiansPerSecond]
    """bound of each component of the angular velocity"""


class Posture(t.Group):
    """Geometric limits of a gait."""

    clearance: t.NonNegative[t.Metres]
    """of the swing foot at mid-step, parabola over the step"""
    clearance_margin: t.NonNegative[t.Metres]
    """added at the nodes, for what happens between them"""
    clearance_from: Annotated[t.Share, t.Unit("fraction of step"), Field(lt=0.5)]
    """from this phase to as long before touchdown; outside the foot has only not to scuff"""
    swing_height: t.Positive[t.Metres]
    """greatest height of the swing foot"""
    foot_separation_min: t.NonNegative[t.Metres]
    """least lateral distance of the feet"""
    foot_separation_max: t.Positive[t.Metres]
    """greatest lateral distance of the feet"""
    legs_apart: t.NonNegative[t.Metres]
    """least lateral distance of feet, and of the tubes' upper ends, in the base's axes"""
    torso_roll: t.NonNegative[t.Radians]
    torso_pitch: t.NonNegative[t.Radians]
    torso_yaw: t.NonNegative[t.Radians]
    torso_rate: t.NonNegative[t.RadiansPerSecond]
    """bound of each component of the angular velocity"""
    knee_min: t.NonNegative[t.Radians]
    """least virtual knee flexion; away from the straight leg"""
    knee_max: t.Positive[t.Radians]
    """greatest virtual knee flexion"""


class ContactLimits(t.Group):
    """What the ground may do to the stance foot."""

    friction: t.Positive[t.Factor]
    """Coulomb coefficient that the gait may use"""
    min_vertical: Annotated[t.Share, t.Unit("fraction of weight")]
    """least vertical force at toe and heel"""


class SolverConfig(t.Group):
    """IPOPT settings and what is tried in turn."""

    max_iterations: t.Count
    """greatest number of iterations of a start"""
    tolerance: t.Tolerance
    """IPOPT tol"""
    constraint_tolerance: t.Tolerance
    """IPOPT constr_viol_tol, in the scaled units of the problem"""
    guesses: t.Distinct[t.Some[Literal["cold", "fast", "crouched", "ramp"]]]
    """starts tried until one converges, by anchors at once: knees bent most, long steps (crouched);
    short quick steps (fast); less bent, long steps (cold); warm starts from walking in place
    (ramp)"""


class StartSpread(t.Group):
    """Random initial guesses, uniform about the crouched walk and within ``gait.step_time``."""

    joints: t.Positive[t.Radians]
    """greatest change of a Bézier coefficient, of each joint and step by itself"""
    crouch: t.Interval[t.Positive[t.Radians]]
    """knee flexion"""
    stride: t.Interval[t.Positive[t.Factor]]
    """step length, as a share of that at the commanded velocity"""


Nodes = t.Odd[Annotated[int, Field(ge=5, le=201)]]


class FormulationConfig(t.Group):
    """What a gait is, the same for all velocities; see ``docs/explanation/method.md``."""

    nodes: Nodes
    """collocation nodes per step"""
    degree: Annotated[int, Field(ge=3, le=12)]
    """of the joints' Bézier polynomials of the phase, the virtual constraints"""
    dynamics: Literal["prismatic", "knee"]
    """whose bodies move: the real leg's and its rotors', or the virtual knee's"""
    cost: Literal["paper", "transport"]
    """paper: eq. 2 as read in docs/paper.md; transport: mean |power| / (m g)"""
    voltage: t.Positive[t.Share]
    """share of the bus that motors may use at the nodes; the rest is for between them"""
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
    """of further rows at every node, by their names in ``slider.gait.constraints``, SI units"""


class SolveConfig(t.Group):
    """How a gait is found and converted."""

    kinematic_map: Literal["exact", "paper"]
    """eq. 1, knee to slide: exact geometry, or the matrix as printed"""
    decoupling_min: Annotated[float, t.Unit("rad/s² | m/s²"), Field(ge=0, le=1e4)]
    """least singular value of the decoupling matrix, per share of the motors' torque limits"""
    step_time: t.Interval[t.Positive[t.Seconds]]
    """bounds of the duration of a step"""
    solver: SolverConfig


class GaitConfig(SolveConfig, FormulationConfig):
    """One gait per velocity of the grid."""

    grid: GridConfig


class LibraryConfig(t.Group):
    """How gaits are collected."""

    allow_holes: bool
    """false: a gait that did not converge stops the library with a list of them"""
    max_violation: Annotated[t.Tolerance, t.Unit("SI")]
    """worst constraint violation of a gait that counts as converged"""


class IntegratorConfig(t.Group):
    """Tolerances of DOP853."""

    relative: t.Tolerance
    absolute: Annotated[t.Tolerance, t.Unit("rad, rad/s")]


class CheckConfig(t.Group):
    """What the checks of a single gait need."""

    integrator: IntegratorConfig
    points: Annotated[t.Count, Field(ge=2)]
    """per step, for the resampling between nodes"""


class VerificationConfig(CheckConfig):
    """All of the verification."""

    chunk: t.Count
    """gaits per job"""
    on_failure: Literal["error", "report"]
    """report: a bound that does not hold is written down; error: it ends the collecting job"""
    bounds: dict[str, Annotated[t.NonNegative[t.Number], t.Unit("of the quantity")] | None]
    """of the quantity, see docs/reference/verification.md; null: reported only"""
