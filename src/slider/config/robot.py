"""Typed robot parameters.

Values and their provenance live in ``conf/robot``.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import Field

from slider.config import types as t
from slider.core.files import flatten

Provenance = Literal["measured", "paper", "earlier", "assumed"]

LINKS = {
    "hip_yaw": "yaw",
    "hip_roll": "roll",
    "hip_pitch": "pitch",
    "slide": "tube",
    "ankle": "foot",
    "upper_foot": "upper_foot",
}
"""Joint → link below it; a knee is listed under the name ``slide``."""
SOLE_LINKS = LINKS | {"ankle": "talus", "ankle_roll": "foot"}
"""Joint → link below it of a leg whose foot has a sole."""
HIP_JOINTS, BELOW_HIP = ("hip_yaw", "hip_roll", "hip_pitch"), tuple(SOLE_LINKS)[3:]
LATERAL = ("hip_yaw", "hip_roll", "ankle_roll")
"""Joints whose angle changes its sign under reflection at the sagittal plane."""
LEAST_BEND = 0.02  # distance of a knee from the line from hip to ankle, as a share of leg length


def leg_scale(leg_length: float) -> float:
    """Leg length [m] as a multiple of SLIDER's, for which defaults are chosen."""
    return leg_length / 0.64


MIRROR = np.array([1.0, -1.0, 1.0])
"""Reflection at the sagittal plane."""


def axis_of(name: str, left: Sequence[float] | np.ndarray, lateral: float) -> np.ndarray:
    """Axis (3,) of a joint of the left (``lateral`` 1) or right (−1) leg, given that of the left.

    Joints of ``LATERAL`` change the sign of the y component, the others those of x and z.
    """
    signs = [1.0, lateral, 1.0] if name in LATERAL else [lateral, 1.0, lateral]
    return np.array(left) * signs + 0.0


@dataclass(frozen=True)
class Body:
    """Mass [kg], centre of mass (3,) [m] and inertia (3, 3) [kg m²] about it."""

    mass: float
    com: np.ndarray
    inertia: np.ndarray

    @property
    def reflected(self) -> "Body":
        """The mirrored body of the other side; + 0.0 turns −0 into 0."""
        turned = self.inertia * np.outer(MIRROR, MIRROR)
        return Body(self.mass, self.com * MIRROR + 0.0, turned + 0.0)


class Link(t.Group):
    """A rigid body."""

    mass: t.Positive[t.Kilograms]
    """mass of the body; links of a leg exist once per leg"""
    com: t.Vector3[t.Metres]
    """centre of mass in the frame of the link's joint; the right leg has the opposite sign of y"""
    inertia: t.Vector3[t.Positive[t.KilogramMetres2]]
    """Ixx, Iyy, Izz about the centre of mass, in the axes of the link's frame"""
    products: t.Vector3[Annotated[t.Number, t.Unit("kg m²")]] = (0.0, 0.0, 0.0)
    """Ixy, Ixz, Iyz about the same point; the right leg has the opposite signs of Ixy and Iyz"""

    @property
    def tensor(self) -> np.ndarray:
        """Inertia (3, 3) about the centre of mass [kg m²]."""
        xy, xz, yz = self.products
        return np.diag(self.inertia) + np.array([[0.0, xy, xz], [xy, 0.0, yz], [xz, yz, 0.0]])


def _is_rigid(link: Link) -> bool:
    moments = np.linalg.eigvalsh(link.tensor)
    return moments[0] > 0.0 and 2 * moments[-1] <= moments.sum() * (1 + 1e-9)


_Rigid = Annotated[
    Link, t.Rule("positive principal moments, none above the sum of the others", _is_rigid)
]
_Base = Annotated[
    _Rigid,
    t.Rule(
        "y, Ixy and Iyz of 0: left and right are alike",
        lambda link: link.com[1] == link.products[0] == link.products[2] == 0.0,
    ),
]


class Links(t.Group):
    """The bodies of the prismatic model; all but the base exist once per leg."""

    base: _Base
    yaw: _Rigid
    roll: _Rigid
    pitch: _Rigid
    tube: _Rigid
    foot: _Rigid
    upper_foot: _Rigid | None = None
    """passive link above the leg of a robot with line feet"""
    talus: _Rigid | None = None
    """link between ankle pitch and ankle roll of a robot whose feet have soles"""


_Unit = t.Rule("a unit vector", lambda vector: abs(float(np.linalg.norm(vector)) - 1.0) < 1e-6)
MAX_TURN = 60  # largest angle between a joint's axis and the coordinate axis of its role [°]


def _within(place: int) -> t.Rule:
    least = np.cos(np.deg2rad(MAX_TURN))
    return t.Rule(f"within {MAX_TURN}° of {'xyz'[place]}", lambda vector: vector[place] >= least)


_Leftward = Annotated[t.Vector3[t.Number], _Unit, _within(1)]


class HipAxes(t.Group):
    """Positions of the left hip's axes in the parent link's frame; the right hip is mirrored.

    All frames are parallel to the base frame when all joints are at zero.
    """

    hip_yaw: t.Vector3[t.Metres]
    hip_roll: t.Vector3[t.Metres]
    hip_pitch: t.Vector3[t.Metres]
    """position of the pitch axis, through which a slide passes"""
    order: Annotated[
        tuple[t.Name, t.Name, t.Name],
        t.Rule(
            f"{', '.join(HIP_JOINTS)} in their order from the base down",
            lambda order: sorted(order) == sorted(HIP_JOINTS),
        ),
    ] = HIP_JOINTS
    """order of the hip joints from the base down"""
    yaw_direction: Annotated[t.Vector3[t.Number], _Unit, _within(2)] = (0.0, 0.0, 1.0)
    """unit vector along the left yaw axis; the right axis has the opposite sign of y"""
    roll_direction: Annotated[t.Vector3[t.Number], _Unit, _within(0)] = (1.0, 0.0, 0.0)
    """unit vector along the left roll axis; the right axis has the opposite sign of y"""
    pitch_direction: _Leftward = (0.0, 1.0, 0.0)
    """unit vector along the left pitch axis; the right axis has the opposite signs of x and z"""

    def chain(self, lateral: float = 1.0) -> list[tuple[str, np.ndarray, np.ndarray]]:
        """Joint name, position (3,) [m] and unit vector (3,) of each hip axis, from the base down.

        ``lateral`` is 1 for the left leg, −1 for the right one.
        """
        chain, reflection = [], np.array([1.0, lateral, 1.0])
        for name in self.order:
            left = getattr(self, f"{name.removeprefix('hip_')}_direction")
            place = getattr(self, name) * reflection + 0.0
            chain.append((name, place, axis_of(name, left, lateral)))
        return chain

    @property
    def below_pitch(self) -> np.ndarray:
        """Last left hip joint relative to the pitch axis (3,) [m], with all joints at zero."""
        below = self.order[self.order.index("hip_pitch") + 1 :]
        return sum((np.array(getattr(self, name)) for name in below), np.zeros(3))


class LegJoint(NamedTuple):
    """A joint of a leg: its position (3,) [m] and axis (3,) in the parent link's frame.

    ``slides``: the joint is prismatic, else revolute.
    """

    name: str
    place: np.ndarray
    axis: np.ndarray
    slides: bool


class Sole(t.Group):
    """Foot with an actuated ankle roll, which lies flat on the ground in stance."""

    roll_height: t.Positive[t.Metres]
    """height of the ankle roll axis above the sole; it is centred below the ankle pitch axis"""
    width: t.Positive[t.Metres]
    """lateral distance between the left and right contact points"""


class Geometry(t.Group):
    """Dimensions of the robot."""

    axes: HipAxes
    leg_length: t.Positive[t.Metres]
    """distance from the hip pitch axis down to the ankle, with all joints at zero"""
    ankle_height: t.Positive[t.Metres]
    """height of the ankle axis above the sole"""
    toe: t.Positive[t.Metres]
    """distance from the ankle axis to the front end of the foot"""
    heel: t.Positive[t.Metres]
    """distance from the ankle axis to the rear end of the foot"""
    foot_radius: t.Positive[t.Metres]
    """half the width of a line foot, or half the thickness of a sole"""
    upper_foot_height: t.Positive[t.Metres]
    """height of the upper foot axis above the hip pitch axis at slide = 0, or above the knee"""
    tube_radius: t.Positive[t.Metres]
    """radius of the leg"""
    hip_radius: t.Positive[t.Metres]
    """radius of the hip actuators"""
    base_half_size: t.Vector3[t.Positive[t.Metres]]
    """half sizes of the base, a box between the hips"""
    knee: t.Vector3[t.Metres] | None = None
    """position of the knee relative to the pitch axis, joints at zero; null: the leg slides"""
    knee_direction: _Leftward = (0.0, 1.0, 0.0)
    """unit vector along the left knee axis; the right axis has the opposite signs of x and z"""
    ankle_direction: _Leftward = (0.0, 1.0, 0.0)
    """unit vector along the left ankle axis; the right axis has the opposite signs of x and z"""
    sole: Sole | None = None
    """null: the foot is a line, which can roll on the ground"""

    def __post_init__(self) -> None:
        lateral, expected = self.hip[1], "a sum of y > 0 m: left hips are on the left"
        t.require(lateral > 0.0, "axes", expected, f"{lateral:g}")
        if self.knee is None:
            found, expected = self.knee_direction, "that of y where there is no knee"
            t.require(found == (0.0, 1.0, 0.0), "knee_direction", expected, [*found])
        else:
            (x, _, z), length = self.knee, self.leg_length
            bent = abs(x) >= LEAST_BEND * length and -length < z < 0.0
            expected = f"z between hip and ankle, x of {LEAST_BEND:.0%} of leg_length or more: bent"
            t.require(bent, "knee", expected, [*self.knee])

    @property
    def leg_joints(self) -> tuple[str, ...]:
        """Joints of a leg from the hip down; a knee is named ``slide``."""
        last = "upper_foot" if self.sole is None else "ankle_roll"
        return (*self.axes.order, "slide", "ankle", last)

    @property
    def links(self) -> dict[str, str]:
        """The link below each of ``leg_joints``."""
        links = LINKS if self.sole is None else SOLE_LINKS
        return {name: links[name] for name in self.leg_joints}

    @property
    def ankle_roll(self) -> np.ndarray:
        """Point on the roll axis (along x) of a stance leg, relative to the ankle (3,) [m]."""
        height = 0.0 if self.sole is None else self.sole.roll_height
        return np.array([0.0, 0.0, height - self.ankle_height])

    @property
    def sole_height(self) -> float:
        """Height of the last ankle joint (pitch, or roll with a sole) above the ground [m]."""
        return self.ankle_height + (0.0 if self.sole is None else self.ankle_roll[2])

    @property
    def sagittal(self) -> tuple[int, int, int]:
        """Indices of hip pitch, slide or knee, and ankle among the joints of a leg."""
        pitch, slide, ankle = map(self.leg_joints.index, ("hip_pitch", "slide", "ankle"))
        return pitch, slide, ankle

    @property
    def hip(self) -> tuple[float, float, float]:
        """Position of the left pitch axis in the base frame, with all joints at zero [m]."""
        above = self.axes.order[: self.axes.order.index("hip_pitch") + 1]
        places = (getattr(self.axes, name) for name in above)
        x, y, z = (sum(values) for values in zip(*places, strict=True))
        return x, y, z

    def leg(self, lateral: float = 1.0) -> list[LegJoint]:
        """Driven joints of a left (1) or right (−1) leg, from the base down."""
        reflection, up = np.array([1.0, lateral, 1.0]), np.eye(3)[2]
        knee, slides = np.array(self.knee or (0.0, 0.0, 0.0)), self.knee is None
        hip = [LegJoint(*joint, slides=False) for joint in self.axes.chain(lateral)]
        below = reflection * (knee - self.axes.below_pitch) + 0.0
        ankle = reflection * (-self.leg_length * up - knee) + 0.0
        along = 0.0 - up if slides else axis_of("slide", self.knee_direction, lateral)
        turns = axis_of("ankle", self.ankle_direction, lateral)
        extension = LegJoint("slide", below, along, slides)
        return [*hip, extension, LegJoint("ankle", ankle, turns, slides=False)]

    @property
    def slide_length(self) -> float | None:
        """Length of a leg at slide = 0 [m]; None for a leg with a knee."""
        return self.leg_length if self.knee is None else None

    @property
    def bend(self) -> float:
        """Knee angle with all joints at zero [rad], > 0 if the knee points forward; 0 without."""
        if self.knee is None:
            return 0.0
        thigh, shank, axis = np.array(self.knee), -np.array(self.knee), self.knee_direction
        shank[2] -= self.leg_length
        thigh, shank = (part - (part @ axis) * np.array(axis) for part in (thigh, shank))
        return float(np.arctan2(np.cross(thigh, shank) @ axis, thigh @ shank))

    @property
    def standing_height(self) -> float:
        """Height of the base above the ground, with all joints at zero [m]."""
        return self.leg_length + self.ankle_height - self.hip[2]


class VirtualKnee(t.Group):
    """Revolute leg that replaces the slide in the gait solver."""

    thigh_length: t.Positive[t.Metres]
    """length of the virtual thigh, l₁"""
    shank_length: t.Positive[t.Metres]
    """length of the virtual shank, l₂"""
    shank_mass_fraction: t.Share
    """share of the tube's mass that moves with the virtual shank"""


class Joint(t.Group):
    """Range (of the left leg's joint) and passive properties of a joint."""

    lower: t.JointPosition
    upper: t.JointPosition
    damping: Annotated[t.NonNegative[t.Number], t.Unit("N m s/rad | N s/m")]
    """viscous damping"""
    armature: Annotated[t.NonNegative[t.Number], t.Unit("kg m² | kg")]
    """inertia of the joint itself; that of the drives is added"""


class Drive(t.Group):
    """Motor with gearbox; units are N, m/s and kg for a slide without a capstan."""

    torque: t.Positive[t.NewtonMetres]
    """torque limit"""
    speed: t.Positive[t.RadiansPerSecond]
    """no-load speed of the torque-speed line"""
    stall_ratio: Annotated[t.Factor, Field(ge=1)]
    """stall torque of the torque-speed line as a multiple of the torque limit"""
    inertia: t.NonNegative[t.KilogramMetres2]
    """rotor inertia reflected to the output; in addition to the joint's ``armature``"""


class Gains(t.Group):
    """PD gains of a motor's onboard position loop."""

    kp: Annotated[t.NonNegative[t.Number], t.Unit("N m/rad")]
    kd: Annotated[t.NonNegative[t.Number], t.Unit("N m s/rad")]


class Capstan(t.Group):
    """Differential of slide and ankle, moved by two equal motors (``drives.capstan``)."""

    drum_radius: Annotated[t.Positive[t.Factor], t.Unit("m/rad")]
    """travel of the slide per angle of both motors turning in the same direction"""
    foot_ratio: t.Positive[t.Factor]
    """angle of the foot per angle of both motors turning in opposite directions"""


class Contact(t.Group):
    """Foot-ground contact."""

    friction: t.Positive[t.Factor]
    """coefficient of the foot on the ground"""


class Mechanism(t.Group):
    """The part of the robot that gaits depend on; joints and drives are keyed by name."""

    geometry: Geometry
    links: Links
    virtual_knee: VirtualKnee | None
    """null: gaits use the joints of the leg itself, as with a real knee"""
    joints: dict[str, Annotated[Joint, t.ordered("lower", "upper", strict=True)]]
    drives: dict[str, Drive]
    capstan: Capstan | None
    """null: slide and ankle have one motor each"""

    def __post_init__(self) -> None:
        geometry, virtual = self.geometry, self.virtual_knee
        t.require(geometry.knee is None or self.capstan is None, "capstan", "null with a knee")
        for name in ("upper_foot", "talus"):
            wanted = name in geometry.links.values()
            expected = f"{'a link' if wanted else 'none'} with geometry.sole {geometry.sole}"
            found = getattr(self.links, name)
            t.require(wanted == (found is not None), f"links.{name}", expected, found)
        t.complete("joints", self.joints, geometry.leg_joints)
        t.complete("drives", self.drives, dict.fromkeys(self.leg_motors))
        if virtual is not None:
            directions = {geometry.axes.pitch_direction, geometry.ankle_direction}
            slides = geometry.knee is None and geometry.sole is None
            level = geometry.axes.order[-1] == "hip_pitch" and directions == {(0.0, 1.0, 0.0)}
            expected = (
                "null with a knee, a sole, a tilted axis, or a pitch that is not the hip's last"
            )
            t.require(slides and level, "virtual_knee", expected, "one")
            reach = virtual.thigh_length + virtual.shank_length
            expected = f"thigh + shank longer than the leg ({geometry.leg_length} m)"
            t.require(reach > geometry.leg_length, "virtual_knee", expected, reach)

    @property
    def sliding_leg(self) -> VirtualKnee:
        """The virtual knee.

        Raises:
            ValueError: the robot has none.
        """
        if self.virtual_knee is None:
            raise ValueError("expected a robot with a virtual knee, found one without")
        return self.virtual_knee

    @property
    def leg_motors(self) -> tuple[str, ...]:
        """Names of a leg's motors (keys of ``drives``), from the hip down."""
        below = ("slide", "ankle") if self.capstan is None else ("capstan",) * 2
        last = () if self.geometry.sole is None else ("ankle_roll",)
        return self.geometry.axes.order + below + last

    @property
    def joint_ranges(self) -> np.ndarray:
        """Lower and upper limits (2, 12) of all joints [rad, m], left leg first."""
        names = self.geometry.leg_joints
        left = np.array([[self.joints[n].lower, self.joints[n].upper] for n in names]).T
        right = np.where([name in LATERAL for name in names], -left[::-1], left)
        return np.concatenate([left, right], axis=1)


class RobotConfig(Mechanism):
    """Everything that defines the robot; gains are keyed by leg motor."""

    name: t.Name
    gains: dict[str, Gains]
    contact: Contact
    provenance: dict[str, Provenance | None] = field(default_factory=dict)
    """origin of values by dotted path; the longest matching path applies; null: no tag"""

    def __post_init__(self) -> None:
        super().__post_init__()
        t.complete("gains", self.gains, dict.fromkeys(self.leg_motors))
        paths = [f"{path}." for path in flatten(asdict(self))]  # paths below a null value are valid
        for group in self.provenance:
            part = f"{group}."
            known = any(path.startswith(part) or part.startswith(path) for path in paths)
            t.require(known, "provenance", "keys below robot", group)
