"""Layout of the gait library's Zarr store; documented in ``docs/reference/gait-library.md``."""

from slider.robot.names import CHANNELS, JOINTS, KNEE_JOINTS, SIDES

SCHEMA = "slider-gait-library"
VERSION = 1

# Axes after the first one, which is the gait.
AXES: dict[str, tuple[str, ...]] = {
    "velocities": ("component",),
    "samples": ("sample", "channel"),
    "time": ("sample",),
    "step_time": ("step",),
    "base": ("sample", "base_channel"),
    "contact": ("sample", "foot"),
    "coefficients": ("step", "knee_joint", "coefficient"),
    "roll": ("step", "node", "roll_channel"),
    "knee_positions": ("sample", "knee_joint"),
    "knee_velocities": ("sample", "knee_joint"),
    "knee_torques": ("sample", "knee_joint"),
    "efforts": ("sample", "joint"),
    "ground_wrench": ("sample", "wrench_component"),
    "swing_foot": ("sample", "coordinate"),
    "cost": (),
    "max_violation": (),
    "iterations": (),
    "residuals": ("constraint",),
}
ARRAYS = tuple(AXES)

# Names along the axes: one-dimensional arrays of text, which xarray takes for coordinates.
# The names of the constraints are the formulation's and come with the gaits.
CONSTRAINT = "constraint"
LABELS: dict[str, tuple[str, ...]] = {
    "component": ("vx", "vy"),
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
    "roll_channel": ("roll", "roll_rate", "roll_acceleration"),
}
# What the gaits were made for and with, and the velocities that have none.
ATTRIBUTES = ("holes", "robot", "kinematic_map", "cost_unit")
# One value per gait, beside its place in the arrays.
GAIT_COORDINATES: dict[str, str] = {"vx": "m/s", "vy": "m/s", "status": "IPOPT's return status"}

UNITS: dict[str, str] = {
    "velocities": "m/s",
    "samples": "see channel_units",
    "time": "s",
    "step_time": "s",
    "base": "m, quaternion w x y z, m/s (world), rad/s (base)",
    "contact": "1: stance",
    "coefficients": "rad",
    "roll": "rad, rad/s, rad/s^2",
    "knee_positions": "rad",
    "knee_velocities": "rad/s",
    "knee_torques": "N m",
    "efforts": "N m, N (slide)",
    "ground_wrench": "N, N m at the foot line, world axes",
    "swing_foot": "m relative to the stance foot",
    "cost": "see cost_unit",
    "max_violation": "SI unit of the worst constraint",
    "iterations": "1",
    "residuals": "unit of the constraint",
}
