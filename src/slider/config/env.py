"""Typed settings of the simulated environment, and of what disturbs the robots in it.

See ``docs/how-to/disturb.md``.
"""

from dataclasses import field
from typing import Annotated, Literal

from pydantic import Field

from slider.config import types as t
from slider.config.robot import BELOW_HIP, HIP_JOINTS

_Impedance = Annotated[t.Share, Field(gt=0, lt=1)]


class SoleContact(t.Group):
    """Softness of the feet on the ground, as MuJoCo's ``solref`` and ``solimp`` have it."""

    time_constant: t.Positive[t.Seconds]
    """in which a foot that has sunk in comes up, critically damped; two timesteps or more"""
    impedance: tuple[_Impedance, _Impedance]
    """share of a foot's acceleration that is taken away: at the surface and at ``depth``"""
    depth: t.Positive[t.Metres]
    """at which the impedance is the second one"""


class PhysicsConfig(t.Group):
    """Simulation step, its repetitions per control step, solver iterations and contact."""

    timestep: t.Positive[t.Seconds]
    substeps: Annotated[t.Count, Field(le=1000)]
    """simulation steps per control step"""
    solver_iterations: Annotated[t.Count, Field(le=10_000)]
    """greatest number of iterations of the contact solver"""
    line_search_iterations: Annotated[t.Count, Field(le=10_000)]
    """greatest number of iterations of its line search"""
    contact: SoleContact

    def __post_init__(self) -> None:
        settling, least = self.contact.time_constant, 2 * self.timestep
        expected = f"two timesteps ({least} s) or more, as MuJoCo needs"
        t.require(settling > least - 1e-9, "contact.time_constant", expected, settling)


class ActionConfig(t.Group):
    """Desired joint position = origin + scale · clip(action)."""

    offset: Literal["nominal", "gait"]
    """origin: the nominal pose, or the gait of the reference velocity at the clock's phase"""
    clip: t.Positive[t.Number]
    """bound of |action|"""
    scale: dict[str, Annotated[t.NonNegative[t.Number], t.Unit("rad | m")]]
    """per leg joint"""

    def __post_init__(self) -> None:
        t.complete("scale", self.scale, HIP_JOINTS + BELOW_HIP)


class HeightScan(t.Group):
    """Grid of points around the base at which ground height is measured."""

    points_x: Annotated[t.Count, Field(le=1000)]
    points_y: Annotated[t.Count, Field(le=1000)]
    spacing: t.Positive[t.Metres]
    """distance of neighbouring points"""


class ObservationConfig(t.Group):
    """Observation terms in order, each with its scale, and the clip after scaling."""

    terms: Annotated[dict[str, t.Positive[t.Number]], Field(min_length=1)]
    """scale of the term"""
    clip: t.Positive[t.Number]
    """bound of |observation|, after scaling"""
    height_scan: HeightScan
    velocity_filter: t.Seconds
    """time constant of filtered velocities and of their reference; 0: not filtered"""

    def filter_gain(self, period: float) -> float:
        """Share of the way that filtered velocities go per control period [s]."""
        return period / max(period, self.velocity_filter)


class ReferenceConfig(t.Group):
    """The velocity that goes from one commanded velocity to the next.

    Clock, guide and the gait under the actions are those of the reference velocity.
    """

    acceleration: t.MetresPerSecond2
    """with which it goes to the commanded velocity, along x and y; 0: at once"""


class SensorsConfig(t.Group):
    """Errors of encoders, inertial unit, motor currents and height scan.

    All are standard deviations but ``scan_drop_out`` and ``scan_delay``. White noise is drawn at
    each reading, a bias once per episode.
    """

    joint_position: t.NonNegative[t.Radians]
    slide_position: t.NonNegative[t.Metres]
    joint_velocity: t.NonNegative[t.RadiansPerSecond]
    slide_velocity: t.NonNegative[t.MetresPerSecond]
    joint_bias: t.NonNegative[t.Radians]
    """of encoder zeros; slides have none"""
    angular_velocity: t.NonNegative[t.RadiansPerSecond]
    angular_velocity_bias: t.NonNegative[t.RadiansPerSecond]
    orientation: t.NonNegative[t.Radians]
    """of the inertial unit about each axis"""
    tilt_bias: t.NonNegative[t.Radians]
    """of roll and pitch"""
    heading_drift: t.NonNegative[t.RadiansPerSecond]
    """rate at which the heading goes astray"""
    velocity_increment: t.NonNegative[t.MetresPerSecond]
    """of the inertial unit's velocity increments over a second"""
    acceleration_bias: t.NonNegative[t.MetresPerSecond2]
    torque: t.NonNegative[t.Factor]
    """error of each motor's torque constant"""
    scan: t.NonNegative[t.Metres]
    """of each point of the height scan"""
    scan_bias: t.NonNegative[t.Metres]
    """of the whole scan"""
    scan_drop_out: t.Share
    """of its points, which read the ground under the feet"""
    scan_delay: t.Seconds
    """by which the map under the scan is late: it is off by this times the velocity"""


class EstimatorConfig(t.Group):
    """Kalman filter of velocity and height; see ``slider.env.estimator``."""

    acceleration: t.Positive[t.MetresPerSecond2]
    """standard deviation of the acceleration by the inertial unit, white"""
    bias_time: t.Positive[t.Seconds]
    """time constant of its bias, the tilt's included"""
    vertical_velocity: t.Positive[t.MetresPerSecond]
    """standard deviation of the vertical velocity that the height is predicted with"""
    leg_velocity: t.Positive[t.MetresPerSecond]
    """standard deviation of the velocity by a leg that carries the robot"""
    leg_height: t.Positive[t.Metres]
    """standard deviation of the height by a leg that carries the robot"""
    slip: t.Positive[t.MetresPerSecond]
    """a foot that appears to slip at this speed counts half"""
    lifted: t.Share
    """of the weight: a foot that carries less is in the air"""
    loaded: t.Share
    """of the weight: a foot that carries more stands"""
    force_filter: t.Seconds
    """time constant of the feet's forces"""


class OnboardConfig(t.Group):
    """Sensors of the robot, and the estimator that reads them."""

    sensors: SensorsConfig
    estimator: Annotated[EstimatorConfig, t.ordered("lifted", "loaded", strict=True)]


Sensing = Literal["true_state", "onboard"]


class TerminationConfig(t.Group):
    """What ends an episode."""

    terms: dict[str, float]
    """parameter of the active termination term, which says its bounds"""


class StartNoise(t.Group):
    """Standard deviations of a robot's start about the nominal pose at rest."""

    joint_position: t.NonNegative[t.Radians]
    slide_position: t.NonNegative[t.Metres]
    tilt: t.NonNegative[t.Radians]
    linear_velocity: t.NonNegative[t.MetresPerSecond]
    angular_velocity: t.NonNegative[t.RadiansPerSecond]
    joint_velocity: t.NonNegative[t.RadiansPerSecond]


class HaltConfig(t.Group):
    """At zero velocity the clock stays at the next change of feet, both of them on the ground."""

    below: t.NonNegative[t.MetresPerSecond]
    """it stays once the low-passed velocity is less than this; 0: never, step in place"""
    above: t.NonNegative[t.MetresPerSecond]
    """it runs on when the velocity is more than this: the robot tips over"""


class PhaseConfig(t.Group):
    """Clock that runs through the two steps of a walk."""

    enabled: bool
    """whether there is a clock"""
    mirror: bool
    """reflect observation and action in right stance: the network sees left stance only"""
    step_time: t.Seconds
    """fixed duration of a step; 0: that of the gait library at the reference velocity"""
    halt: Annotated[HaltConfig, t.ordered("below", "above")]

    def __post_init__(self) -> None:
        possible = self.enabled or not (self.mirror or self.halt.below > 0)
        t.require(possible, "", "a clock for mirror and halt", "none")


class PlantConfig(t.Group):
    """The part of an environment that does not depend on who controls the robot."""

    control_period: t.Positive[t.Seconds]
    """time between two outputs of the policy; timestep × substeps"""
    physics: PhysicsConfig
    termination: TerminationConfig
    onboard: OnboardConfig | None = None
    """sensors and estimator; null in the section of a stage that does not use them"""

    def __post_init__(self) -> None:
        found = self.physics.timestep * self.physics.substeps
        expected = f"timestep × substeps = control_period ({self.control_period} s)"
        t.require(abs(found - self.control_period) < 1e-9, "physics", expected, found)

    @property
    def estimation(self) -> OnboardConfig | None:
        """Sensors and estimator, if controllers receive their estimate."""
        return self.onboard


class EnvConfig(PlantConfig, kw_only=True):
    """Observations and actions of a policy, and what ends an episode."""

    reference: ReferenceConfig
    action: ActionConfig
    observation: ObservationConfig
    phase: PhaseConfig
    start: StartNoise = field(default_factory=lambda: StartNoise(0, 0, 0, 0, 0, 0))
    sensing: Sensing = "true_state"
    """what agents receive: the true state, or its estimate from sensors on board"""

    def __post_init__(self) -> None:
        super().__post_init__()
        possible, offset = self.phase.enabled or self.action.offset == "nominal", self.action.offset
        t.require(possible, "action.offset", "nominal where there is no phase", offset)

    @property
    def estimation(self) -> OnboardConfig | None:
        """Sensors and estimator, if controllers receive their estimate."""
        return self.onboard if self.sensing == "onboard" else None

    @property
    def estimator(self) -> EstimatorConfig:
        """The estimator on board, also of robots whose controllers receive the true state."""
        assert self.onboard is not None, "validated"
        return self.onboard.estimator

    @property
    def plant(self) -> PlantConfig:
        """The part for controllers other than the policy."""
        return PlantConfig(self.control_period, self.physics, self.termination, self.estimation)


class SensingConfig(t.Group):
    """Standard deviations of white noise on what a controller receives about the robot."""

    joint_position: t.NonNegative[t.Radians]
    slide_position: t.NonNegative[t.Metres]
    joint_velocity: t.NonNegative[t.RadiansPerSecond]
    slide_velocity: t.NonNegative[t.MetresPerSecond]
    angular_velocity: t.NonNegative[t.RadiansPerSecond]
    orientation: t.NonNegative[t.Radians]
    """of the base about each axis, and with it the direction of gravity"""
    linear_velocity: t.NonNegative[t.MetresPerSecond]
    base_height: t.NonNegative[t.Metres]


ControlTime = Annotated[t.Positive[t.Seconds], t.Multiple("env.control_period")]
PhysicsTime = Annotated[t.Seconds, t.Multiple("env.physics.timestep")]


class PushConfig(t.Group):
    """A horizontal force on the base, at regular times."""

    impulse: t.Interval[t.NonNegative[t.NewtonSeconds]]
    """force times duration, drawn anew for each push; 0: no pushes"""
    duration: ControlTime
    """of a push"""
    interval: ControlTime
    """time from the start and between pushes"""
    direction: t.Radians | None
    """from the world's x axis, along which robots start, to y; null: drawn anew for each push"""


TerrainKind = Literal[
    "flat",
    "slope_up",
    "slope_down",
    "slope_across",
    "step_up",
    "step_down",
    "stairs_up",
    "stairs_down",
    "gaps",
    "tiles",
    "rough",
]
Level = Annotated[float, t.Unit("-"), Field(ge=0, le=20)]


class TerrainConfig(t.Group):
    """Ground under the robots; ``slider.env.terrain`` has what a level is of each kind."""

    kinds: t.Some[TerrainKind]
    """of the robots in turn"""
    level: t.Interval[Level]
    """drawn per robot and episode"""
    curriculum: bool
    """in trainings, in place of that: from ``lower`` one up after an episode of 1 m without a fall,
    one down after a fall; beyond ``upper`` drawn"""


class DisturbanceConfig(t.Group):
    """What is drawn per robot and episode, uniformly in the intervals, and what happens in it."""

    sensing: SensingConfig
    delay: t.Interval[PhysicsTime]
    """from the controller's output to the drives"""
    motor_gain: t.Interval[t.Positive[t.Factor]]
    """achieved over demanded torque, each drive its own"""
    mass: t.Interval[t.Positive[t.Factor]]
    """of all links over the nominal one, one value per robot"""
    centre_of_mass: t.NonNegative[t.Metres]
    """of the base: largest shift along each axis"""
    friction: t.Interval[t.Positive[t.Factor]] | None
    """of the feet on the ground; null: robot.contact.friction"""
    payload: t.Interval[t.Kilograms]
    """added to the base at its centre of mass"""
    push: Annotated[PushConfig, t.ordered("duration", "interval", strict=True)]
    terrain: TerrainConfig
