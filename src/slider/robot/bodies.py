"""Rigid bodies of the gait solver's two legs, from the same parameters as the MuJoCo model.

The prismatic leg is the real leg, except that the passive, light upper foot is part of the tube. In
the virtual-knee leg the tube's mass is split between virtual thigh and shank
(``shank_mass_fraction``). The shank's part has its centre at mid-shank; the thigh's part is placed
such that, at the nominal length, the leg's centre of mass along the leg is that of the prismatic
leg. The upper foot moves with the thigh. The leg's inertia about the hip is then a third larger
than the prismatic leg's, since the virtual knee sticks out. Reflected inertias are not included.
Bodies are those of a left leg, each in the frame of its proximal joint.
"""

from collections.abc import Mapping

import numpy as np

from slider.config.robot import Body, Link, Mechanism
from slider.robot.knee_map import sides


def own_bodies(robot: Mechanism) -> dict[str, Body]:
    """``base``, and ``yaw``, ``roll``, ``pitch``, ``tube``, ``foot`` (``sole``) of one real leg."""
    links = robot.links
    bodies = {name: _body(getattr(links, name)) for name in ("base", "yaw", "roll", "pitch")}
    if links.talus is not None:
        bodies |= {"tube": _body(links.tube), "foot": _body(links.talus)}
        return bodies | {"sole": _body(links.foot)}
    tube = joined(_body(links.tube), _upper_foot(robot))
    return bodies | {"tube": tube, "foot": _body(links.foot)}


def knee_bodies(robot: Mechanism) -> dict[str, Body]:
    """``base``; ``yaw``, ``roll``, ``pitch`` (thigh), ``shank``, ``foot`` of a virtual-knee leg."""
    links = robot.links
    bodies = {name: _body(getattr(links, name)) for name in ("base", "yaw", "roll")}
    knee = robot.sliding_leg
    shank = _part(links.tube, knee.shank_mass_fraction, -knee.shank_length / 2)
    return bodies | {"pitch": _thigh(robot), "shank": shank, "foot": _body(links.foot)}


def total_mass(bodies: Mapping[str, Body]) -> float:
    """Mass of the base and of two equal legs [kg]."""
    return bodies["base"].mass + 2 * sum(b.mass for name, b in bodies.items() if name != "base")


def joined(*parts: Body) -> Body:
    """Several bodies as one rigid body, by the parallel axis theorem."""
    mass = sum(part.mass for part in parts)
    com = np.sum([part.mass * part.com for part in parts], axis=0) / mass
    inertia = np.zeros((3, 3))
    for part in parts:
        offset = part.com - com
        steiner = (offset @ offset) * np.eye(3) - np.outer(offset, offset)
        inertia += part.inertia + part.mass * steiner
    return Body(mass, com, inertia)


def _body(link: Link) -> Body:
    return Body(link.mass, np.array(link.com), link.tensor)


def _upper_foot(robot: Mechanism) -> Body:
    """The upper foot in the frame of the slide."""
    link = robot.links.upper_foot
    assert link is not None  # since there is no sole
    com = np.array(link.com) + [0.0, 0.0, robot.geometry.upper_foot_height]
    return Body(link.mass, com, link.tensor)


def _part(tube: Link, share: float, height: float) -> Body:
    """A share of the tube's length, with its centre at ``height`` above the joint [m]."""
    inertia = np.diag(share**3 * np.array(tube.inertia) * [1, 1, 1 / share**2])
    return Body(share * tube.mass, np.array([0.0, 0.0, height]), inertia)


def _thigh(robot: Mechanism) -> Body:
    """Pitch link, upper foot and the rest of the tube, placed to keep the leg's centre of mass."""
    geometry, links, knee = robot.geometry, robot.links, robot.sliding_leg
    rest = 1 - knee.shank_mass_fraction
    tube, upper = links.tube, _upper_foot(robot)
    l1, l2 = knee.thigh_length, knee.shank_length
    # Flexion at which hip and ankle are the nominal leg length apart.
    flexion = float(np.arccos((geometry.leg_length**2 - l1**2 - l2**2) / (2 * l1 * l2)))
    tilt, _, _ = sides(flexion, l1, l2)
    shank_centre = (l1 * np.cos(tilt) + geometry.leg_length) / 2  # along the leg, as the following
    above = upper.mass * upper.com[2]
    above += links.pitch.mass * links.pitch.com[2]
    below = -tube.mass * tube.com[2] - (1 - rest) * tube.mass * shank_centre
    depth = (below - above * (1 - np.cos(tilt))) / (rest * tube.mass * np.cos(tilt))
    return joined(_body(links.pitch), _part(tube, rest, -depth), _upper_foot(robot))
