"""Joints and inertias of a leg for pinocchio, read from the parameter file.

Nothing is shared with the models of the optimisation: ``prismatic_leg`` is the leg as it is built,
``knee_leg`` the virtual knee that carries its mass.
"""

# pinocchio lies below cmeel.prefix, where pyright does not look.
# pyright: reportMissingImports=false

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from slider.config.robot import Link, Mechanism

_UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class LegJoint:
    """A joint and the body below it.

    Attributes:
        kind: of the pinocchio joint.
        height: of the joint in the frame above [m].
        body: inertia in the joint's frame.
        rotor, damping: what acts about or along the joint beside the body [kg m², kg], [N m s/rad].
    """

    kind: pin.JointModel
    height: float
    body: pin.Inertia
    rotor: float = 0.0
    damping: float = 0.0


def inertia_of(link: Link, share: float = 1.0) -> pin.Inertia:
    """A link in the frame of its joint, or a part of it cut across the leg's axis.

    A part of a rod keeps the share s of mass, s³ of the inertia across and s of that along.
    """
    scale = np.array([share**3, share**3, share])
    return pin.Inertia(share * link.mass, np.array(link.com), np.diag(scale * link.inertia))


def raised(body: pin.Inertia, height: float) -> pin.Inertia:
    """A body whose frame lies at a height [m] of another one."""
    return pin.SE3(np.eye(3), height * _UP).act(body)


def prismatic_leg(robot: Mechanism) -> list[LegJoint]:
    """Hip, slide and ankle; the upper foot is held by the tube, the rotors turn with their joints.

    A rotor of inertia I in both capstan motors at angles s/r ± β/n has the energy of 2I/r² at the
    slide and of 2I/n² at the ankle.
    """
    links, geometry, capstan = robot.links, robot.geometry, robot.capstan
    pair = 2.0 * robot.drives["capstan"].inertia
    rotors = {name: drive.inertia for name, drive in robot.drives.items()}
    rotors |= {"slide": pair / capstan.drum_radius**2, "ankle": pair / capstan.foot_ratio**2}
    upper = raised(inertia_of(links.upper_foot), geometry.upper_foot_height)
    down = pin.JointModelPrismaticUnaligned(-_UP)
    chain = {
        "hip_yaw": (pin.JointModelRZ(), 0.0, inertia_of(links.yaw)),
        "hip_roll": (pin.JointModelRX(), 0.0, inertia_of(links.roll)),
        "hip_pitch": (pin.JointModelRY(), 0.0, inertia_of(links.pitch)),
        "slide": (down, 0.0, inertia_of(links.tube) + upper),
        "ankle": (pin.JointModelRY(), -geometry.leg_length, inertia_of(links.foot)),
    }
    return [
        LegJoint(*part, rotors[name] + robot.joints[name].armature, robot.joints[name].damping)
        for name, part in chain.items()
    ]


def knee_leg(robot: Mechanism) -> list[LegJoint]:
    """Hip, virtual knee and ankle, without rotors and friction."""
    links, knee = robot.links, robot.virtual_knee
    shank_part = inertia_of(links.tube, knee.shank_mass_fraction)
    shank_part.lever = -knee.shank_length / 2 * _UP
    bend = pin.JointModelRevoluteUnaligned(np.array([0.0, -1.0, 0.0]))
    return [
        LegJoint(pin.JointModelRZ(), 0.0, inertia_of(links.yaw)),
        LegJoint(pin.JointModelRX(), 0.0, inertia_of(links.roll)),
        LegJoint(pin.JointModelRY(), 0.0, _thigh(robot)),
        LegJoint(bend, -knee.thigh_length, shank_part),
        LegJoint(pin.JointModelRY(), -knee.shank_length, inertia_of(links.foot)),
    ]


def _thigh(robot: Mechanism) -> pin.Inertia:
    """Pitch link, upper foot and the tube's rest.

    The rest's place balances the leg: at the nominal length, with the knee bent, the first moment
    of all links along the line from hip to ankle is that of the prismatic leg.
    """
    links, geometry, knee = robot.links, robot.geometry, robot.virtual_knee
    l1, l2, length = knee.thigh_length, knee.shank_length, geometry.leg_length
    along = (l1**2 + length**2 - l2**2) / (2 * l1 * length)  # cosine between thigh and leg
    fixed = inertia_of(links.pitch)
    fixed += raised(inertia_of(links.upper_foot), geometry.upper_foot_height)
    share = knee.shank_mass_fraction
    shank = -share * links.tube.mass * (l1 * along + length) / 2
    rest = inertia_of(links.tube, 1.0 - share)
    above = fixed.mass * fixed.lever[2]
    wanted = above + links.tube.mass * links.tube.com[2]
    rest.lever = (wanted - above * along - shank) / (rest.mass * along) * _UP
    return fixed + rest
