"""Layout of the gait library's Zarr store; documented in ``docs/reference/gait-library.md``."""

from typing import NamedTuple

from slider.robot.names import CHANNELS, COMMAND, JOINTS, KNEE_JOINTS, SIDES

SCHEMA = "slider-gait-library"
VERSION = 3


class Array(NamedTuple):
    """An array of the store.

    Attributes:
        unit: of its values.
        axes: after the first one, which is the gait.
    """

    unit: str
    axes: tuple[str, ...] = ()


ARRAYS: dict[str, Array] = {
    "commands": Array("m/s, m/s, rad/s", ("component",)),
    "samples": Array("see channel_units", ("sample", "channel")),
    "time": Array("s", ("sample",)),
    "step_time": Array("s", ("step",)),
    "base": Array("m, quaternion w x y z, m/s (world), rad/s (base)", ("sample", "base_channel")),
    "contact": Array("1: stance", ("sample", "foot")),
    "coefficients": Array("rad", ("step", "knee_joint", "coefficient")),
    "roll": Array("rad, rad/s, rad/s^2", ("step", "node", "roll_channel")),
    "decoupling": Array("rad/s^2 | m/s^2, 1", ("sample", "decoupling_channel")),
    "knee_positions": Array("rad", ("sample", "knee_joint")),
    "knee_velocities": Array("rad/s", ("sample", "knee_joint")),
    "knee_torques": Array("N m", ("sample", "knee_joint")),
    "efforts": Array("N m, N (slide)", ("sample", "joint")),
    "ground_wrench": Array("N, N m at the foot line, world axes", ("sample", "wrench_component")),
    "swing_foot": Array("m relative to the stance foot", ("sample", "coordinate")),
    "cost": Array("see cost_unit"),
    "max_violation": Array("SI unit of the worst constraint"),
    "iterations": Array("1"),
    "residuals": Array("unit of the constraint", ("constraint",)),
}
# One value per gait, beside its place in the arrays; xarray takes them for coordinates.
COORDINATES: dict[str, Array] = {
    "vx": Array("m/s"),
    "vy": Array("m/s"),
    "yaw_rate": Array("rad/s"),
    "status": Array("IPOPT's return status"),
}

# Names along the axes: one-dimensional arrays of text, which xarray takes for coordinates.
# The names of the constraints are the formulation's and come with the gaits.
CONSTRAINT = "constraint"
LABELS: dict[str, tuple[str, ...]] = {
    "component": COMMAND,
    "channel": CHANNELS,
    "joint": JOINTS,
    "knee_joint": KNEE_JOINTS,
    "step": SIDES,  # by its stance foot
    "foot": SIDES,
    "base_channel": (
        *("x", "y", "z"),
        *("qw", "qx", "qy", "qz"),
        *("vx", "vy", "vz"),
        *("wx", "wy", "wz"),
    ),
    "wrench_component": ("fx", "fy", "fz", "mx", "my", "mz"),
    "coordinate": ("x", "y", "z"),
    "decoupling_channel": ("least_singular_value", "condition_number"),
    "roll_channel": ("roll", "roll_rate", "roll_acceleration"),
}

# What the gaits were made for and with, which the configuration says (``gait.*``), ...
ORIGIN = ("robot", "dynamics", "transcription", "cost", "kinematic_map")
# ... and what their optimisation adds: the commands that have no gait, the unit of the cost.
OUTCOME = ("holes", "cost_unit")
