"""Checks of the robot's parameters."""

from collections.abc import Iterable
from dataclasses import fields

from slider.config.robot import RobotConfig
from slider.config.validation.checks import (
    all_at_least,
    all_positive,
    at_least,
    positive,
    require,
)
from slider.robot.names import LEG_DRIVES, LEG_JOINTS


def check_robot(robot: RobotConfig) -> None:
    """Joints, drives, links, capstan and legs."""
    _names("robot.joints", robot.joints, LEG_JOINTS)
    _names("robot.drives", robot.drives, LEG_DRIVES)
    _names("robot.gains", robot.gains, LEG_DRIVES)
    for name, joint in robot.joints.items():
        require(joint.lower < joint.upper, f"robot.joints.{name}", "lower < upper", joint)
        all_at_least(f"robot.joints.{name}", joint, ("damping", "armature"), 0.0)
    for name, drive in robot.drives.items():
        all_positive(f"robot.drives.{name}", drive, ("torque", "speed", "inertia"))
        at_least(f"robot.drives.{name}.stall_ratio", drive.stall_ratio, 1.0)
    for name, gains in robot.gains.items():
        all_at_least(f"robot.gains.{name}", gains, ("kp", "kd"), 0.0)
    all_positive("robot.contact", robot.contact, ["friction"])
    all_positive("robot.geometry", robot.geometry, ("foot_radius", "tube_radius", "hip_radius"))
    for index, half in enumerate(robot.geometry.base_half_size):
        positive(f"robot.geometry.base_half_size[{index}]", half)
    for item in fields(robot.links):
        positive(f"robot.links.{item.name}.mass", getattr(robot.links, item.name).mass)
    all_positive("robot.capstan", robot.capstan, [item.name for item in fields(robot.capstan)])
    _legs(robot)


def check_joints(key: str, found: Iterable[str]) -> None:
    """Exactly the joints of a leg, in any order."""
    _names(key, found, LEG_JOINTS)


def _names(key: str, found: Iterable[str], expected: Iterable[str]) -> None:
    found, expected = tuple(found), tuple(expected)
    require(set(found) == set(expected), key, ", ".join(expected), ", ".join(found))


def _legs(robot: RobotConfig) -> None:
    length, knee = robot.geometry.leg_length, robot.virtual_knee
    positive("robot.geometry.leg_length", length)
    reach = knee.thigh_length + knee.shank_length
    expected = f"thigh + shank longer than the leg ({length} m)"
    require(reach > length, "robot.virtual_knee", expected, reach)
