"""Bodies of the prismatic leg for the gait solver, from the same parameters as the plant.

The upper foot is part of the tube: it is passive, light and swings little.
"""

from dataclasses import dataclass

import numpy as np

from slider.config.robot import Mechanism
from slider.robot.knee_model import Body, body_of, joined
from slider.robot.names import LEG_JOINTS, LEG_MOTORS
from slider.robot.transmission import leg_inertia


@dataclass(frozen=True)
class PrismaticModel:
    """Bodies by name (``base`` and one leg), and what acts at a leg's joints.

    Attributes:
        bodies: ``base``, ``yaw``, ``roll``, ``pitch``, ``tube``, ``foot``.
        inertia: of rotors and joints (5, 5), beside the bodies' [kg m², kg].
        damping: viscous (5,) [N m s/rad, N s/m].
    """

    bodies: dict[str, Body]
    inertia: np.ndarray
    damping: np.ndarray


def build_prismatic_model(robot: Mechanism) -> PrismaticModel:
    """The leg as it is built."""
    links, joints = robot.links, robot.joints
    upper = body_of(links.upper_foot)
    top = Body(upper.mass, upper.com + [0.0, 0.0, robot.geometry.upper_foot_height], upper.inertia)
    bodies = {name: body_of(getattr(links, name)) for name in ("base", "yaw", "roll", "pitch")}
    bodies |= {"tube": joined(body_of(links.tube), top), "foot": body_of(links.foot)}
    damping = np.array([joints[name].damping for name in LEG_JOINTS[: len(LEG_MOTORS)]])
    return PrismaticModel(bodies, leg_inertia(robot), damping)
