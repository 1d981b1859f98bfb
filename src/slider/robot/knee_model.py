"""Bodies of the virtual-knee model, from the same parameters as the prismatic model.

The tube's mass is split between virtual thigh and shank (``shank_mass_fraction``). The shank's
part has its centre at mid-shank; the thigh's part lies where the leg's centre of mass at the
nominal length, seen along the leg, is that of the prismatic leg. The upper foot moves with the
thigh. The leg's inertia about the hip is then a third larger than the prismatic leg's, as the
virtual knee sticks out. Reflected inertias are not part of this model.
"""

from dataclasses import dataclass

import numpy as np

from slider.config.robot import Geometry, Link, Links, VirtualKnee

LEG_BODIES = ("yaw", "roll", "thigh", "shank", "foot")


@dataclass(frozen=True)
class Body:
    """Mass [kg], centre of mass (3,) [m] and diagonal inertia (3,) [kg m²] about it.

    The frame's origin is the joint on the side of the hip.
    """

    mass: float
    com: np.ndarray
    inertia: np.ndarray


@dataclass(frozen=True)
class KneeModel:
    """The virtual-knee robot: bodies by name (``base`` and one leg) and lengths [m]."""

    bodies: dict[str, Body]
    hip_offset: float
    thigh: float
    shank: float
    ankle_height: float
    toe: float
    heel: float

    @property
    def mass(self) -> float:
        """Total mass [kg]."""
        return self.bodies["base"].mass + 2 * sum(self.bodies[name].mass for name in LEG_BODIES)


def build_knee_model(geometry: Geometry, links: Links, knee: VirtualKnee) -> KneeModel:
    """Distribute the prismatic leg's links over the virtual-knee leg."""
    return KneeModel(
        bodies={
            "base": body_of(links.base),
            "yaw": body_of(links.yaw),
            "roll": body_of(links.roll),
            "thigh": _thigh(geometry, links, knee),
            "shank": _shank(links.tube, knee),
            "foot": body_of(links.foot),
        },
        hip_offset=geometry.hip_offset,
        thigh=knee.thigh_length,
        shank=knee.shank_length,
        ankle_height=geometry.ankle_height,
        toe=geometry.toe,
        heel=geometry.heel,
    )


def nominal_flexion(geometry: Geometry, knee: VirtualKnee) -> float:
    """Knee flexion [rad] at which hip and ankle are the nominal leg length apart."""
    l1, l2 = knee.thigh_length, knee.shank_length
    return float(np.arccos((geometry.leg_length**2 - l1**2 - l2**2) / (2 * l1 * l2)))


def body_of(link: Link) -> Body:
    """A link as a body."""
    return Body(link.mass, np.array(link.com), np.array(link.inertia))


def _shank(tube: Link, knee: VirtualKnee) -> Body:
    share = knee.shank_mass_fraction
    com = np.array([0.0, 0.0, -knee.shank_length / 2])
    return Body(share * tube.mass, com, share**3 * np.array(tube.inertia) * [1, 1, 1 / share**2])


def _thigh(geometry: Geometry, links: Links, knee: VirtualKnee) -> Body:
    """Pitch link, upper foot and the tube's rest, which lies where the leg's mass balances."""
    rest = 1 - knee.shank_mass_fraction
    tube, upper = links.tube, links.upper_foot
    flexion, l1, l2 = nominal_flexion(geometry, knee), knee.thigh_length, knee.shank_length
    tilt = np.arctan2(l2 * np.sin(flexion), l1 + l2 * np.cos(flexion))
    shank_centre = (l1 * np.cos(tilt) + geometry.leg_length) / 2  # along the leg, as all of these
    above = upper.mass * (upper.com[2] + geometry.upper_foot_height)
    above += links.pitch.mass * links.pitch.com[2]
    below = -tube.mass * tube.com[2] - (1 - rest) * tube.mass * shank_centre
    depth = (below - above * (1 - np.cos(tilt))) / (rest * tube.mass * np.cos(tilt))
    part = Body(
        rest * tube.mass,
        np.array([0.0, 0.0, -depth]),
        rest**3 * np.array(tube.inertia) * [1, 1, 1 / rest**2],
    )
    top = np.array(upper.com) + [0.0, 0.0, geometry.upper_foot_height]
    return joined(body_of(links.pitch), part, Body(upper.mass, top, np.array(upper.inertia)))


def joined(*parts: Body) -> Body:
    """One rigid body; all centres of mass lie on the z axis of the frame."""
    mass = sum(part.mass for part in parts)
    com = np.sum([part.mass * part.com for part in parts], axis=0) / mass
    inertia = np.zeros(3)
    for part in parts:
        offset = part.com - com
        inertia += part.inertia + part.mass * (offset @ offset - offset**2)
    return Body(mass, com, inertia)
