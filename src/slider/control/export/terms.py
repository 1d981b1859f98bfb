"""What the terms of an observation mean to someone who has a robot but not this package."""

from dataclasses import dataclass

from slider.env.observations import VELOCITY_ERROR_RANGE
from slider.robot.names import CHANNEL_UNITS, JOINTS, NUM_JOINTS

BASE, HEADING, WORLD, NONE = "base", "heading", "world", "none"


@dataclass(frozen=True)
class Meaning:
    """A term in words.

    Attributes:
        components: name of each value, in order.
        units: unit of each value before scaling; one for all, or one each.
        frame: base (moves with the trunk), heading (turned by the yaw only), world or none.
        text: how to get the value.
    """

    components: tuple[str, ...]
    units: tuple[str, ...]
    frame: str
    text: str


_XYZ = ("x", "y", "z")

MEANINGS = {
    "base_linear_velocity": Meaning(
        _XYZ, ("m/s",), BASE, "velocity of the base's origin, in axes of the base"
    ),
    "target_linear_velocity": Meaning(
        ("vx", "vy", "0"), ("m/s",), HEADING, "commanded velocity, and 0"
    ),
    "base_angular_velocity": Meaning(
        _XYZ, ("rad/s",), BASE, "angular velocity of the base, in axes of the base (gyroscope)"
    ),
    "target_angular_velocity": Meaning(
        ("0", "0", "yaw_rate"), ("rad/s",), BASE, "0, 0 and the commanded yaw rate"
    ),
    "projected_gravity": Meaning(
        _XYZ, ("-",), BASE, "unit vector of gravity in axes of the base: (0, 0, -1) when upright"
    ),
    "command": Meaning(
        ("vx", "vy", "yaw_rate", "heading_error"),
        ("m/s", "m/s", "rad/s", "rad"),
        HEADING,
        "commands; heading_error = (target - yaw) wrapped to [-pi, pi), where target starts at "
        "the yaw of the start and moves on by yaw_rate times control_period each control step",
    ),
    "joint_positions": Meaning(
        JOINTS, CHANNEL_UNITS[:NUM_JOINTS], NONE, "joint position minus action.joints[i].nominal"
    ),
    "joint_velocities": Meaning(
        JOINTS, CHANNEL_UNITS[NUM_JOINTS : 2 * NUM_JOINTS], NONE, "joint velocity"
    ),
    "previous_action": Meaning(
        JOINTS, ("-",), NONE, "the last action: clipped, reflected back, 0 where its scale is 0"
    ),
    "action_before_previous": Meaning(
        JOINTS, ("-",), NONE, "the action before the last one, likewise; 0 at the start"
    ),
    "base_height": Meaning(
        ("z",), ("m",), WORLD, "height of the base's origin above the ground minus nominal_height"
    ),
    "filtered_velocity": Meaning(
        ("forward", "leftward"),
        ("m/s",),
        HEADING,
        "f += velocity_filter.gain * (v - f) each control step but the first, f = 0 at the start; "
        "v is the base's velocity turned by minus the yaw",
    ),
    "velocity_error": Meaning(
        ("forward", "leftward"),
        ("-",),
        HEADING,
        f"tanh((filtered_velocity - expected) / {VELOCITY_ERROR_RANGE} m/s): each control step but "
        "the first, after the reference velocity has moved, expected += velocity_filter.gain * "
        "(reference velocity - expected), 0 at the start",
    ),
    "reference_velocity": Meaning(
        ("vx", "vy"), ("m/s",), HEADING, "the reference velocity; see reference.meaning"
    ),
    "phase": Meaning(
        ("sin", "cos"), ("-",), NONE, "sine and cosine of 2 pi times the clock; 0, 0 when halted"
    ),
    "height_scan": Meaning(
        (), ("m",), HEADING, "height of the base's origin above points of a grid around it"
    ),
}
