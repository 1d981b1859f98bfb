"""Typed settings of what disturbs the simulated robots; see ``docs/how-to/disturb.md``."""

from pydantic.dataclasses import dataclass

from slider.config.interval import Interval
from slider.config.strict import STRICT


@dataclass(frozen=True, config=STRICT)
class SensingConfig:
    """Standard deviations of white noise on what a controller is told about the robot.

    Hinges [rad], [rad/s]; slides [m], [m/s]; base angular velocity [rad/s], orientation about each
    axis [rad], linear velocity [m/s], height [m].
    """

    joint_position: float
    slide_position: float
    joint_velocity: float
    slide_velocity: float
    angular_velocity: float
    orientation: float
    linear_velocity: float
    base_height: float


@dataclass(frozen=True, config=STRICT)
class PushConfig:
    """Change of the base's horizontal velocity [m/s] in a random direction, every ``interval`` s.

    A ``speed`` of zero means no pushes.
    """

    speed: float
    interval: float


@dataclass(frozen=True, config=STRICT)
class GroundConfig:
    """Grid of random heights within ± ``amplitude`` [m], with square cells of ``cell`` [m].

    It repeats every ``period`` [m]. An ``amplitude`` of zero is flat ground.
    """

    amplitude: float
    cell: float
    period: float


@dataclass(frozen=True, config=STRICT)
class DisturbanceConfig:
    """What is drawn per robot and episode, uniformly in the intervals, and what happens in it.

    Attributes:
        sensing: noise on the state that the controller is given.
        delay: between a controller's output and the drives [s], multiples of the simulation step.
        motor_gain: achieved over demanded torque of each drive [-].
        mass: of all links over the nominal one [-], one value per robot.
        centre_of_mass: of the base, largest shift along each axis [m].
        friction: of the feet on the ground [-]; none: the robot's.
        push: impulses on the base.
        ground: uneven ground.
    """

    sensing: SensingConfig
    delay: Interval
    motor_gain: Interval
    mass: Interval
    centre_of_mass: float
    friction: Interval | None
    push: PushConfig
    ground: GroundConfig
