"""Typed settings of the simulated environment: the same for training and evaluation."""

from dataclasses import field

from pydantic.dataclasses import dataclass

from slider.config.strict import STRICT


@dataclass(frozen=True, config=STRICT)
class PhysicsConfig:
    """Simulation step [s], its repetitions per control step, and solver iterations."""

    timestep: float
    substeps: int
    solver_iterations: int
    line_search_iterations: int


@dataclass(frozen=True, config=STRICT)
class ActionConfig:
    """Desired joint position = origin + scale · clip(action); scale [rad or m] per leg joint.

    ``offset`` says what the origin is: the ``nominal`` pose, or the ``gait`` of the reference
    velocity at the clock's phase, so that the action is a residual.
    """

    offset: str
    clip: float
    scale: dict[str, float]


@dataclass(frozen=True, config=STRICT)
class HeightScan:
    """Grid of points around the base at which ground height is measured."""

    points_x: int
    points_y: int
    spacing: float


@dataclass(frozen=True, config=STRICT)
class ObservationConfig:
    """Observation terms in order, each with its scale, and the clip after scaling.

    ``velocity_filter`` [s] low-passes the velocity, and the reference that it is compared with.
    """

    terms: dict[str, float]
    clip: float
    height_scan: HeightScan
    velocity_filter: float

    def filter_gain(self, period: float) -> float:
        """Share of the way that filtered velocities go per control period [s]."""
        return period / max(period, self.velocity_filter)


@dataclass(frozen=True, config=STRICT)
class ReferenceConfig:
    """The reference velocity goes to the command with ``acceleration`` [m/s²]; 0: at once.

    Clock, guide and the gait under the actions are those of the reference velocity.
    """

    acceleration: float


@dataclass(frozen=True, config=STRICT)
class TerminationConfig:
    """Active termination terms: name → parameter."""

    terms: dict[str, float]


@dataclass(frozen=True, config=STRICT)
class StartNoise:
    """Standard deviations of a robot's start: [rad], [m], [rad], [m/s], [rad/s], [rad/s]."""

    joint_position: float
    slide_position: float
    tilt: float
    linear_velocity: float
    angular_velocity: float
    joint_velocity: float


@dataclass(frozen=True, config=STRICT)
class HaltConfig:
    """At zero command the clock stays at the next change of feet once the low-passed velocity is
    less than ``below``, and runs on when the velocity is more than ``above`` [m/s]; 0: never stays.
    """

    below: float
    above: float


@dataclass(frozen=True, config=STRICT)
class PhaseConfig:
    """Clock that runs through the two steps of a walk; ``mirror`` shows left stance only.

    ``step_time`` [s] fixes its pace; at 0 it has the step times of the gait library.
    """

    enabled: bool
    mirror: bool
    step_time: float
    halt: HaltConfig


@dataclass(frozen=True, config=STRICT)
class PlantConfig:
    """The part of an environment that does not depend on who controls the robot."""

    control_period: float
    physics: PhysicsConfig
    termination: TerminationConfig


@dataclass(frozen=True, config=STRICT)
class EnvConfig:
    """What a controller of the robot sees and commands, and what ends an episode."""

    control_period: float
    physics: PhysicsConfig
    reference: ReferenceConfig
    action: ActionConfig
    observation: ObservationConfig
    termination: TerminationConfig
    phase: PhaseConfig
    start: StartNoise = field(default_factory=lambda: StartNoise(0, 0, 0, 0, 0, 0))
