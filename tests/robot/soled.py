"""A robot whose feet have soles, and the settings of its gaits."""

from dataclasses import replace
from functools import cache

from slider.config.robot import Joint, Link, RobotConfig, Sole
from tests.robot.lopsided import kneed


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
