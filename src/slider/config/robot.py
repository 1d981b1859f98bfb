"""Typed robot parameters. Values and their provenance live in ``conf/robot``."""

from dataclasses import field
from typing import Any

from pydantic.dataclasses import dataclass

from slider.config.strict import STRICT, Vector3


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
    tube_radius: float
    hip_radius: float
    base_half_size: Vector3


@dataclass(frozen=True, config=STRICT)
class VirtualKnee:
    """The revolute leg that stands for the slide in the gait solver."""

    thigh_length: float
    shank_length: float
    shank_mass_fraction: float


@dataclass(frozen=True, config=STRICT)
class Joint:
    """Position range [rad or m], viscous damping [N m s/rad or N s/m].

    ``armature``: inertia of its own, beside that of the drives [kg m² or kg].
    """

    lower: float
    upper: float
    damping: float
    armature: float


@dataclass(frozen=True, config=STRICT)
class Drive:
    """A motor with its gear.

    Attributes:
        torque: limit [N m].
        speed: where the torque-speed line ends [rad/s].
        stall_ratio: torque of that line at rest, as a multiple of the limit [-].
        inertia: of the rotor, reflected to the output [kg m²].
    """

    torque: float
    speed: float
    stall_ratio: float
    inertia: float


@dataclass(frozen=True, config=STRICT)
class Gains:
    """Position loop on board of a motor: [N m/rad], [N m s/rad]."""

    kp: float
    kd: float


@dataclass(frozen=True, config=STRICT)
class Capstan:
    """Differential of slide and foot, moved by two equal motors (``drives.capstan``).

    ``drum_radius``: way of the slide per angle of both motors in the same sense [m/rad];
    ``foot_ratio``: angle of the foot per angle of both in opposite senses [-].
    """

    drum_radius: float
    foot_ratio: float


@dataclass(frozen=True, config=STRICT)
class Contact:
    """Foot-ground contact."""

    friction: float


@dataclass(frozen=True, config=STRICT)
class Mechanism:
    """What gaits depend on: joints by leg joint, drives by leg drive."""

    geometry: Geometry
    links: Links
    virtual_knee: VirtualKnee
    joints: dict[str, Joint]
    drives: dict[str, Drive]
    capstan: Capstan


@dataclass(frozen=True, config=STRICT)
class RobotConfig(Mechanism):
    """Everything that defines the machine; gains by leg drive."""

    name: str
    gains: dict[str, Gains]
    contact: Contact
    provenance: dict[str, Any] = field(default_factory=dict)
