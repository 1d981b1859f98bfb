"""Typed robot parameters. Values and their provenance live in ``conf/robot``."""

from dataclasses import field
from typing import Any

from pydantic.dataclasses import dataclass

from slider.core.config.strict import STRICT, Vector3


@dataclass(frozen=True, config=STRICT)
class Link:
    """A rigid body: mass [kg], centre of mass in its own frame [m], diagonal inertia [kg m²]."""

    mass: float
    com: Vector3
    inertia: Vector3


@dataclass(frozen=True, config=STRICT)
class Links:
    """The bodies of the prismatic model; all but the base exist once per leg."""

    base: Link
    yaw: Link
    roll: Link
    pitch: Link
    tube: Link
    foot: Link
    upper_foot: Link


@dataclass(frozen=True, config=STRICT)
class Geometry:
    """Lengths [m]."""

    hip_offset: float
    leg_length: float
    ankle_height: float
    toe: float
    heel: float
    foot_radius: float
    upper_foot_height: float


@dataclass(frozen=True, config=STRICT)
class VirtualKnee:
    """The revolute leg that stands for the slide in the gait solver."""

    thigh_length: float
    shank_length: float
    shank_mass_fraction: float


@dataclass(frozen=True, config=STRICT)
class JointLimits:
    """Position range [rad or m], effort [N m or N] and speed [rad/s or m/s]."""

    lower: float
    upper: float
    effort: float
    speed: float


@dataclass(frozen=True, config=STRICT)
class Capstan:
    """Differential drive of slide and foot by two equal motors.

    ``drum_radius``: way of the slide per angle of both motors in the same sense [m/rad];
    ``foot_ratio``: angle of the foot per angle of both in opposite sense [-]; ``torque``: limit of
    each motor, gears included [N m].
    """

    drum_radius: float
    foot_ratio: float
    torque: float


@dataclass(frozen=True, config=STRICT)
class JointDrive:
    """Reflected inertia [kg m² or kg], viscous damping [N m s/rad or N s/m].

    ``stall_ratio``: torque of the torque-speed line at rest, as a multiple of the effort limit;
    the line ends at the speed limit.
    """

    armature: float
    damping: float
    stall_ratio: float


@dataclass(frozen=True, config=STRICT)
class JointGains:
    """PD gains [N m/rad or N/m] and [N m s/rad or N s/m]."""

    kp: float
    kd: float


@dataclass(frozen=True, config=STRICT)
class Contact:
    """Foot-ground contact."""

    friction: float


@dataclass(frozen=True, config=STRICT)
class RobotConfig:
    """Everything that defines the machine. The joint tables are keyed by leg joint."""

    name: str
    geometry: Geometry
    links: Links
    virtual_knee: VirtualKnee
    limits: dict[str, JointLimits]
    capstan: Capstan
    drives: dict[str, JointDrive]
    gains: dict[str, JointGains]
    contact: Contact
    provenance: dict[str, Any] = field(default_factory=dict)
