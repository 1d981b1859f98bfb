"""Typed settings of what disturbs the simulated robots; see ``docs/how-to/disturb.md``."""

from pydantic.dataclasses import dataclass

from slider.config.types import (
    STRICT,
    Factor,
    Interval,
    Metres,
    MetresPerSecond,
    NonNegative,
    Positive,
    Radians,
    RadiansPerSecond,
    Seconds,
)


@dataclass(frozen=True, config=STRICT)
class SensingConfig:
    """Standard deviations of white noise on what a controller receives about the robot."""

    joint_position: NonNegative[Radians]
    slide_position: NonNegative[Metres]
    joint_velocity: NonNegative[RadiansPerSecond]
    slide_velocity: NonNegative[MetresPerSecond]
    angular_velocity: NonNegative[RadiansPerSecond]
    orientation: NonNegative[Radians]
    """of the base about each axis, and with it the direction of gravity"""
    linear_velocity: NonNegative[MetresPerSecond]
    base_height: NonNegative[Metres]


@dataclass(frozen=True, config=STRICT)
class PushConfig:
    """Change of the base's horizontal velocity in a random direction."""

    speed: NonNegative[MetresPerSecond]
    """change of the base's horizontal velocity; 0: no pushes"""
    interval: Positive[Seconds]
    """time from the start and between pushes, a multiple of env.control_period"""


@dataclass(frozen=True, config=STRICT)
class GroundConfig:
    """Grid of random heights."""

    amplitude: NonNegative[Metres]
    """heights are uniform within ± this; 0: flat ground"""
    cell: Positive[Metres]
    """edge of its square cells"""
    period: Positive[Metres]
    """the ground repeats itself, a multiple of cell"""


@dataclass(frozen=True, config=STRICT)
class DisturbanceConfig:
    """What is drawn per robot and episode, uniformly in the intervals, and what happens in it."""

    sensing: SensingConfig
    delay: Interval[Seconds]
    """from the controller's output to the drives, multiples of env.physics.timestep"""
    motor_gain: Interval[Positive[Factor]]
    """achieved over demanded torque, each drive its own"""
    mass: Interval[Positive[Factor]]
    """of all links over the nominal one, one value per robot"""
    centre_of_mass: NonNegative[Metres]
    """of the base: largest shift along each axis"""
    friction: Interval[Positive[Factor]] | None
    """of the feet on the ground; null: robot.contact.friction"""
    push: PushConfig
    ground: GroundConfig
