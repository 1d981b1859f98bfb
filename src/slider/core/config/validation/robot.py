"""Checks of the robot's parameters."""

from collections.abc import Iterable
from dataclasses import fields

from slider.core.config.robot import RobotConfig
from slider.core.config.validation.checks import all_positive, positive, require
from slider.robot.names import LEG_JOINTS


def check_robot(robot: RobotConfig) -> None:
    """Joints, links, capstan and legs."""
    for table in ("limits", "drives", "gains"):
        check_joints(f"robot.{table}", getattr(robot, table))
    for name, limit in robot.limits.items():
        require(limit.lower < limit.upper, f"robot.limits.{name}", "lower < upper", limit)
    for item in fields(robot.links):
        positive(f"robot.links.{item.name}.mass", getattr(robot.links, item.name).mass)
    all_positive("robot.capstan", robot.capstan, [item.name for item in fields(robot.capstan)])
    _legs(robot)


def check_joints(key: str, found: Iterable[str]) -> None:
    """Exactly the joints of a leg, in any order."""
    found = tuple(found)
    expected = f"the joints {', '.join(LEG_JOINTS)}"
    require(set(found) == set(LEG_JOINTS), key, expected, ", ".join(found))


def _legs(robot: RobotConfig) -> None:
    length, knee = robot.geometry.leg_length, robot.virtual_knee
    positive("robot.geometry.leg_length", length)
    reach = knee.thigh_length + knee.shank_length
    expected = f"thigh + shank longer than the leg ({length} m)"
    require(reach > length, "robot.virtual_knee", expected, reach)
