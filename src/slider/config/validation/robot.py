"""Rules of the robot's parameters."""

from collections.abc import Iterable

from slider.config.legs import LEG_DRIVES, LEG_JOINTS
from slider.config.parameters import parameters
from slider.config.robot import RobotConfig
from slider.config.validation.checks import require


def check_robot(robot: RobotConfig) -> None:
    """Every joint and drive, ranges that are not empty, legs that reach, tags of what there is."""
    check_names("robot.joints", robot.joints, LEG_JOINTS)
    check_names("robot.drives", robot.drives, LEG_DRIVES)
    check_names("robot.gains", robot.gains, LEG_DRIVES)
    for name, joint in robot.joints.items():
        found = f"{joint.lower} and {joint.upper}"
        require(joint.lower < joint.upper, f"robot.joints.{name}", "lower < upper", found)
    length, knee = robot.geometry.leg_length, robot.virtual_knee
    reach = knee.thigh_length + knee.shank_length
    expected = f"thigh + shank longer than the leg ({length} m)"
    require(reach > length, "robot.virtual_knee", expected, reach)
    paths = [f"{item.path}." for item in parameters(robot)]
    for group in robot.provenance:
        known = any(path.startswith(f"{group}.") for path in paths)
        require(known, "robot.provenance", "keys below robot that hold numbers", group)


def check_names(key: str, found: Iterable[str], expected: Iterable[str]) -> None:
    """Exactly the expected ones, in any order."""
    found, expected = tuple(found), tuple(expected)
    require(set(found) == set(expected), key, ", ".join(expected), ", ".join(found))
