"""Units of numbers, from comments as people write them."""

import pytest
from slider.config.units import unit

COMMENTS = {
    "robot.geometry": "[m]",
    "robot.links": "mass [kg], com [m] in the joint's frame, inertia about the com [kg m²]",
    "robot.limits": "position [rad | m], effort [N m | N], speed [rad/s | m/s]",
    "robot.gains": "position loop of the drives [N m/rad | N/m], [N m s/rad | N s/m]",
    "robot.capstan": "two equal motors, same sense = slide",
    "robot.capstan.torque": "of each motor [N m]",
}
LIMITS = ("lower", "upper", "effort", "speed")


@pytest.mark.parametrize(
    ("path", "siblings", "expected"),
    [
        ("robot.geometry.toe", ("toe", "heel"), "m"),
        ("robot.links.base.mass", ("mass", "com", "inertia"), "kg"),
        ("robot.links.base.com", ("mass", "com", "inertia"), "m"),
        ("robot.links.base.inertia", ("mass", "com", "inertia"), "kg m²"),
        ("robot.limits.ankle.lower", LIMITS, "rad"),
        ("robot.limits.slide.upper", LIMITS, "m"),
        ("robot.limits.slide.effort", LIMITS, "N"),
        ("robot.gains.ankle.kp", ("kp", "kd"), "N m/rad"),
        ("robot.gains.slide.kd", ("kp", "kd"), "N s/m"),
        ("robot.capstan.torque", ("radius", "torque"), "N m"),
        ("robot.capstan.radius", ("radius", "torque"), ""),  # nothing says it
        ("robot.gains.ankle.ki", ("kp", "ki", "kd"), ""),  # two units for three numbers
    ],
)
def test_unit(path, siblings, expected):
    assert unit(path, siblings, COMMENTS) == expected
