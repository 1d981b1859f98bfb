"""Typed settings of the simulated environment and of its disturbances.

See ``docs/how-to/disturb.md``.
"""

from dataclasses import field
from typing import Annotated, Literal

from pydantic import Field

from slider.config import types as t
from slider.config.robot import BELOW_HIP, HIP_JOINTS

_Impedance = Annotated[t.Share, Field(gt=0, lt=1)]


class SoleContact(t.Group):
    """Softness of foot-ground contact: MuJoCo's ``solref`` and ``solimp``."""

    time_constant: t.Positive[t.Seconds]
    """time constant of solref, critically damped; at least two timesteps"""
    impedance: tuple[_Impedance, _Impedance]
    """impedance of solimp at the surface and at ``depth``"""
    depth: t.Positive[t.Metres]
    """penetration at which the impedance reaches its second value"""


class PhysicsConfig(t.Group):
    """Time step, number of substeps per control step, solver iterations and contact."""

    timestep: t.Positive[t.Seconds]
    substeps: Annotated[t.Count, Field(le=1000)]
    """simulation steps per control step"""
    solver_iterations: Annotated[t.Count, Field(le=10_000)]
    """maximum number of iterations of the contact solver"""
    line_search_iterations: Annotated[t.Count, Field(le=10_000)]
    """maximum number of iterations of the solver's line search"""
    contact: SoleContact

    def __post_init__(self) -> None:
        settling, least = self.contact.time_constant, 2 * self.timestep
        expected = f"two timesteps ({least} s) or more, as MuJoCo needs"
        t.require(settling > least - 1e-9, "contact.time_constant", expected, settling)


class ActionConfig(t.Group):
    """Desired joint position = origin + scale · clip(action)."""

    offset: Literal["nominal", "gait"]
    """origin: the nominal pose, or the gait at the reference velocity and the clock's phase"""
    clip: t.Positive[t.Number]
    """bound of |action|"""
    scale: dict[str, Annotated[t.NonNegative[t.Number], t.Unit("rad | m")]]
    """scale of the action, per leg joint"""

    def __post_init__(self) -> None:
        t.complete("scale", self.scale, HIP_JOINTS + BELOW_HIP)


class HeightScan(t.Group):
    """Grid of points around the base at which the ground height is measured."""

    points_x: Annotated[t.Count, Field(le=1000)]
    points_y: Annotated[t.Count, Field(le=1000)]
    spacing: t.Positive[t.Metres]
    """distance between neighbouring points"""


class ObservationConfig(t.Group):
    """Observation terms in order, each with its scale, and the clip after scaling."""

    terms: Annotated[dict[str, t.Positive[t.Number]], Field(min_length=1)]
    """scale of the term"""
    clip: t.Positive[t.Number]
    """bound of |observation|, after scaling"""
    height_scan: HeightScan
    velocity_filter: t.Seconds
    """time constant of the low-pass filter on velocities and their reference; 0: no filter"""

    def filter_gain(self, period: float) -> float:
        """Gain of the first-order velocity filter for a control period [s]."""
        return period / max(period, self.velocity_filter)


class ReferenceConfig(t.Group):
    """The reference velocity, which ramps from one commanded velocity to the next.

    It determines the clock, the gait of the guide and the gait that actions are offset by.
    """

    acceleration: t.MetresPerSecond2
    """acceleration of the reference towards the command, along x and y; 0: immediate change"""


class SensorsConfig(t.Group):
    """Errors of encoders, IMU, motor currents and height scan.

    All are standard deviations, except ``scan_drop_out`` and ``scan_delay``. White noise is drawn
    at each reading, a bias once per episode.
    """

    joint_position: t.NonNegative[t.Radians]
    slide_position: t.NonNegative[t.Metres]
    joint_velocity: t.NonNegative[t.RadiansPerSecond]
    slide_velocity: t.NonNegative[t.MetresPerSecond]
    joint_bias: t.NonNegative[t.Radians]
    """bias of encoder zeros; slides have none"""
    angular_velocity: t.NonNegative[t.RadiansPerSecond]
    angular_velocity_bias: t.NonNegative[t.RadiansPerSecond]
    orientation: t.NonNegative[t.Radians]
    """white noise of the IMU's orientation, about each axis"""
    tilt_bias: t.NonNegative[t.Radians]
    """bias of roll and pitch"""
    heading_drift: t.NonNegative[t.RadiansPerSecond]
    """drift rate of the heading"""
    velocity_increment: t.NonNegative[t.MetresPerSecond]
    """white noise of the IMU's velocity increments, accumulated over one second"""
    acceleration_bias: t.NonNegative[t.MetresPerSecond2]
    torque: t.NonNegative[t.Factor]
    """error of each motor's torque constant"""
    scan: t.NonNegative[t.Metres]
    """white noise of each point of the height scan"""
    scan_bias: t.NonNegative[t.Metres]
    """bias common to all points of the scan"""
    scan_drop_out: t.Share
    """share of dropped-out points, which return the ground height under the feet"""
    scan_delay: t.Seconds
    """latency of the map behind the scan, which displaces it by scan_delay × velocity"""


class EstimatorConfig(t.Group):
    """Kalman filter of velocity and height; see ``slider.env.estimator``."""

    acceleration: t.Positive[t.MetresPerSecond2]
    """standard deviation of the IMU's acceleration, white noise"""
    bias_time: t.Positive[t.Seconds]
    """time constant of the acceleration bias, including the effect of a tilt bias"""
    vertical_velocity: t.Positive[t.MetresPerSecond]
    """standard deviation of the vertical velocity in the prediction of the height"""
    leg_velocity: t.Positive[t.MetresPerSecond]
    """standard deviation of the base velocity measured by the odometry of a stance leg"""
    leg_height: t.Positive[t.Metres]
    """standard deviation of the base height measured by a stance leg"""
    slip: t.Positive[t.MetresPerSecond]
    """apparent slip velocity at which a foot gets half the weight"""
    lifted: t.Share
    """share of the robot's weight: a foot that carries less is in the air"""
    loaded: t.Share
    """share of the robot's weight: a foot that carries more is fully in stance"""
    force_filter: t.Seconds
    """time constant of the low-pass filter on foot forces"""


class OnboardConfig(t.Group):
    """Sensors of the robot, and the estimator that reads them."""

    sensors: SensorsConfig
    estimator: Annotated[EstimatorConfig, t.ordered("lifted", "loaded", strict=True)]


Sensing = Literal["true_state", "onboard"]


class TerminationConfig(t.Group):
    """What ends an episode."""

    terms: dict[str, float]
    """parameter of the active termination term; the term defines its bounds"""


class StartNoise(t.Group):
    """Standard deviations of a robot's initial state around the nominal pose at rest."""

    joint_position: t.NonNegative[t.Radians]
    slide_position: t.NonNegative[t.Metres]
    tilt: t.NonNegative[t.Radians]
    linear_velocity: t.NonNegative[t.MetresPerSecond]
    angular_velocity: t.NonNegative[t.RadiansPerSecond]
    joint_velocity: t.NonNegative[t.RadiansPerSecond]


class HaltConfig(t.Group):
    """At zero command the clock halts at the next change of stance foot, in double support."""

    below: t.NonNegative[t.MetresPerSecond]
    """the clock halts once the low-passed velocity is below this; 0: never, step in place"""
    above: t.NonNegative[t.MetresPerSecond]
    """the clock runs again when the velocity reaches this: the robot is tipping over"""


class PhaseConfig(t.Group):
    """Phase clock of the gait cycle, which consists of two steps."""

    enabled: bool
    """whether there is a clock"""
    mirror: bool
    """mirror observation and action in right stance: the network sees left stance only"""
    step_time: t.Seconds
    """fixed duration of a step; 0: that of the gait library at the reference velocity"""
    halt: Annotated[HaltConfig, t.ordered("below", "above")]

    def __post_init__(self) -> None:
        possible = self.enabled or not (self.mirror or self.halt.below > 0)
        t.require(possible, "", "a clock for mirror and halt", "none")


class PlantConfig(t.Group):
    """The part of an environment that does not depend on who controls the robot."""

    control_period: t.Positive[t.Seconds]
    """control period of the policy; equals timestep × substeps"""
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
        """Sensors and estimator, if controllers receive the estimated state."""
        return self.onboard


class EnvConfig(PlantConfig, kw_only=True):
    """Observations and actions of a policy, and the termination of episodes."""

    reference: ReferenceConfig
    action: ActionConfig
    observation: ObservationConfig
    phase: PhaseConfig
    start: StartNoise = field(default_factory=lambda: StartNoise(0, 0, 0, 0, 0, 0))
    sensing: Sensing = "true_state"
    """state that the policy receives: the true one, or the estimate from onboard sensors"""

    def __post_init__(self) -> None:
        super().__post_init__()
        possible, offset = self.phase.enabled or self.action.offset == "nominal", self.action.offset
        t.require(possible, "action.offset", "nominal where there is no phase", offset)

    @property
    def estimation(self) -> OnboardConfig | None:
        """Sensors and estimator, if controllers receive the estimated state."""
        return self.onboard if self.sensing == "onboard" else None

    @property
    def estimator(self) -> EstimatorConfig:
        """The onboard estimator, even if controllers receive the true state."""
        assert self.onboard is not None, "validated"
        return self.onboard.estimator

    @property
    def plant(self) -> PlantConfig:
        """The settings that apply to controllers other than the policy."""
        return PlantConfig(self.control_period, self.physics, self.termination, self.estimation)


class SensingConfig(t.Group):
    """Standard deviations of white noise on the robot state that a controller receives."""

    joint_position: t.NonNegative[t.Radians]
    slide_position: t.NonNegative[t.Metres]
    joint_velocity: t.NonNegative[t.RadiansPerSecond]
    slide_velocity: t.NonNegative[t.MetresPerSecond]
    angular_velocity: t.NonNegative[t.RadiansPerSecond]
    orientation: t.NonNegative[t.Radians]
    """noise of the base orientation about each axis, and thus of the projected gravity"""
    linear_velocity: t.NonNegative[t.MetresPerSecond]
    base_height: t.NonNegative[t.Metres]


ControlTime = Annotated[t.Positive[t.Seconds], t.Multiple("env.control_period")]
PhysicsTime = Annotated[t.Seconds, t.Multiple("env.physics.timestep")]


class PushConfig(t.Group):
    """Horizontal force on the base at regular intervals."""

    impulse: t.Interval[t.NonNegative[t.NewtonSeconds]]
    """force × duration, drawn for each push; 0: no pushes"""
    duration: ControlTime
    """duration of a push"""
    interval: ControlTime
    """time before the first push and between pushes"""
    direction: t.Radians | None
    """angle from the world's x axis (initial heading) towards y; null: drawn for each push"""


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
    """Ground under the robots; ``slider.env.terrain`` defines the levels of each kind."""

    kinds: t.Some[TerrainKind]
    """kinds of terrain, assigned to the robots in turn"""
    level: t.Interval[Level]
    """level, drawn per robot and episode"""
    curriculum: bool
    """in trainings only: levels start at ``lower``, go one up after an episode of 1 m without a
    fall and one down after a fall, and are drawn at random beyond ``upper``"""


class DisturbanceConfig(t.Group):
    """Domain randomisation, drawn uniformly per robot and episode; noise, pushes and terrain."""

    sensing: SensingConfig
    delay: t.Interval[PhysicsTime]
    """actuation delay, from the controller's output to the drives"""
    motor_gain: t.Interval[t.Positive[t.Factor]]
    """ratio of achieved to commanded torque, drawn for each drive"""
    mass: t.Interval[t.Positive[t.Factor]]
    """factor on the nominal masses, one value for all links of a robot"""
    centre_of_mass: t.NonNegative[t.Metres]
    """largest shift of the base's centre of mass along each axis"""
    friction: t.Interval[t.Positive[t.Factor]] | None
    """friction coefficient of the feet on the ground; null: robot.contact.friction"""
    payload: t.Interval[t.Kilograms]
    """mass added to the base at its centre of mass"""
    push: Annotated[PushConfig, t.ordered("duration", "interval", strict=True)]
    terrain: TerrainConfig
