"""Bodies of the virtual-knee model, from the same parameters as the prismatic model.

The tube's mass is split between virtual thigh and shank (``shank_mass_fraction``). The shank's
part has its centre at mid-shank; the thigh's part lies where the leg's centre of mass at the
nominal length, seen along the leg, is that of the prismatic leg (to 1 %: the thigh's tilt is left
out). The upper foot moves with the thigh. The leg's inertia about the hip is then a third larger
than the prismatic leg's, as the virtual knee sticks out. Reflected inertias are not part of this
model.
"""

from dataclasses import dataclass

import numpy as np

from slider.core.config.robot import Geometry, Link, Links, VirtualKnee

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
            "base": _body(links.base),
            "yaw": _body(links.yaw),
            "roll": _body(links.roll),
            "thigh": _thigh(geometry, links, knee),
            "shank": _shank(links.tube, knee),
            "foot": _body(links.foot),
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


def _body(link: Link) -> Body:
    return Body(link.mass, np.array(link.com), np.array(link.inertia))


def _shank(tube: Link, knee: VirtualKnee) -> Body:
    share = knee.shank_mass_fraction
    com = np.array([0.0, 0.0, -knee.shank_length / 2])
    return Body(share * tube.mass, com, share**3 * np.array(tube.inertia) * [1, 1, 1 / share**2])


def _thigh(geometry: Geometry, links: Links, knee: VirtualKnee) -> Body:
    share = knee.shank_mass_fraction
    tube = links.tube
    # Along the leg at the nominal length: distance of the shank's centre from the hip.
    flexion = nominal_flexion(geometry, knee)
    along = np.cos(np.arctan2(np.sin(flexion), knee.shank_length / knee.thigh_length))
    shank_centre = knee.thigh_length * along + (geometry.leg_length - knee.thigh_length * along) / 2
    depth = (-tube.com[2] - share * shank_centre) / (1 - share)
    rest = 1 - share
    part = Body(
        rest * tube.mass,
        np.array([0.0, 0.0, -depth]),
        rest**3 * np.array(tube.inertia) * [1, 1, 1 / rest**2],
    )
    upper = links.upper_foot
    top = np.array(upper.com) + [0.0, 0.0, geometry.upper_foot_height]
    return _joined(_body(links.pitch), part, Body(upper.mass, top, np.array(upper.inertia)))


def _joined(*parts: Body) -> Body:
    """One rigid body; all centres of mass lie on the z axis of the frame."""
    mass = sum(part.mass for part in parts)
    com = np.sum([part.mass * part.com for part in parts], axis=0) / mass
    inertia = np.zeros(3)
    for part in parts:
        offset = part.com - com
        inertia += part.inertia + part.mass * (offset @ offset - offset**2)
    return Body(mass, com, inertia)
