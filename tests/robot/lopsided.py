"""Robots whose legs are as general as the configuration allows, and one that has knees."""

from dataclasses import replace
from functools import cache

import numpy as np

from slider.config.robot import Drive, Gains, HipAxes, Joint, Link, RobotConfig, Sole
from tests import shared
from tests.config.composed import CONF, composed

HIP_Y = {"hip_yaw": 0.15, "hip_roll": 0.0, "hip_pitch": 0.0}  # [m]


@cache
def lopsided() -> RobotConfig:
    """Axes of the hip 2–10 cm apart, centres of mass moved by as much, products of inertia.

    Slide and ankle have a motor each.
    """
    robot, rng = composed().robot, np.random.default_rng(7)
    links = {"base": replace(robot.links.base, products=(0.0, 0.004, 0.0))}
    for name in ("yaw", "roll", "pitch", "tube", "foot", "upper_foot"):
        link = getattr(robot.links, name)
        com = tuple((link.com + moved(rng)).tolist())
        products = tuple((rng.uniform(-0.2, 0.2, 3) * min(link.inertia)).tolist())
        links[name] = replace(link, com=com, products=products)
    axes = {name: tuple((moved(rng) + [0.0, y, 0.0]).tolist()) for name, y in HIP_Y.items()}
    geometry = replace(robot.geometry, axes=HipAxes(**axes))
    drives, gains = ({n: d[n] for n in HIP_Y} for d in (robot.drives, robot.gains))
    drives["slide"] = Drive(torque=600.0, speed=3.0, stall_ratio=2.0, inertia=1.3)
    drives["ankle"] = Drive(torque=15.0, speed=20.0, stall_ratio=2.0, inertia=0.01)
    gains |= {"slide": Gains(kp=6000.0, kd=150.0), "ankle": Gains(kp=50.0, kd=1.0)}
    changes = {"links": replace(robot.links, **links), "drives": drives, "gains": gains}
    return replace(robot, capstan=None, geometry=geometry, **changes)


@shared.shared
def kneed(name: str = "unitree_h1") -> RobotConfig:
    """A robot of the examples, by default Unitree's H1."""
    return composed(f"robot={CONF.parent}/docs/examples/robots/{name}.yaml").robot


@cache
def turned(knee: bool) -> RobotConfig:
    """The hip pitches first, then rolls and yaws; all axes tilted; H1's or sliding legs."""
    robot = kneed() if knee else replace(lopsided(), virtual_knee=None)
    axes_of = {"yaw": unit(0.3, -0.1, 0.9), "roll": unit(0.95, 0.2, -0.25)}
    axes_of |= {"pitch": unit(0.15, 0.85, -0.5)}
    below = {"ankle_direction": unit(-0.1, 0.95, 0.2)}
    below |= {"knee_direction": unit(0.1, 0.9, -0.15)} if knee else {}
    order = ("hip_pitch", "hip_roll", "hip_yaw")
    rng, axes = np.random.default_rng(8), {}
    for name, y in zip(order, (0.1, 0.0, 0.0), strict=True):
        axes[name] = tuple((0.5 * moved(rng) + [0.0, y, 0.0]).tolist())
    directions = {f"{name}_direction": axis for name, axis in axes_of.items()}
    hip = HipAxes(**axes, order=order, **directions)
    return replace(robot, geometry=replace(robot.geometry, axes=hip, **below))


def unit(*vector: float) -> tuple[float, ...]:
    return tuple((np.array(vector) / np.linalg.norm(vector)).tolist())


def moved(rng: np.random.Generator) -> np.ndarray:
    return rng.choice([-1, 1], 3) * rng.uniform(0.02, 0.1, 3)


@cache
def soled() -> RobotConfig:
    """Unitree's G1 with soles: the ankle's roll that the example holds."""
    return with_soles(kneed("unitree_g1"), 0.06, 0.03)


def with_soles(robot: RobotConfig, width: float, height: float) -> RobotConfig:
    """A robot with soles and an axis of the ankles' rolls at a height [m]."""
    geometry = replace(robot.geometry, sole=Sole(roll_height=height, width=width))
    talus = Link(mass=0.074, com=(-0.007, 0.0, 0.011), inertia=(1.9e-5, 1.4e-5, 1.0e-5))
    x, y, z = robot.links.foot.com
    foot = replace(robot.links.foot, com=(x, y, z + geometry.ankle_height - height))
    links = replace(robot.links, talus=talus, foot=foot, upper_foot=None)
    joints = {name: joint for name, joint in robot.joints.items() if name != "upper_foot"}
    joints["ankle_roll"] = Joint(lower=-0.26, upper=0.26, damping=0.5, armature=0.01)
    of = "hip_yaw" if robot.capstan else "ankle"
    drives, gains = (d | {"ankle_roll": d[of]} for d in (robot.drives, robot.gains))
    changes = {"joints": joints, "drives": drives, "gains": gains, "links": links}
    return replace(robot, geometry=geometry, virtual_knee=None, provenance={}, **changes)
