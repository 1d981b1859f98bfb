"""Names of joints, motors, bodies, sites and channels, and gravity.

Joint order: left leg, then right leg, each from hip to foot; ``robot.geometry.axes.order`` is the
order of the hip joints. x forward, y left, z up.
"""

from collections.abc import Iterable

from slider.config.robot import LATERAL, Geometry

SIDES = ("left", "right")
FOOT_ENDS = ("heel", "toe")
LEG_SIZE = 6  # joints of a leg: three of the hip, slide or knee, ankle, upper foot or ankle roll
EXTENSION, ANKLE, LAST = 3, 4, 5  # indices among them
NUM_JOINTS = LEG_SIZE * len(SIDES)
GAIT_JOINTS = tuple(i for i in range(NUM_JOINTS) if i % LEG_SIZE != LAST)
"""Joints that a gait prescribes: an upper foot is passive, an ankle roll keeps the sole level."""
LAST_JOINTS = tuple(i for i in range(NUM_JOINTS) if i % LEG_SIZE == LAST)
LEG_GAIT_JOINTS = LEG_SIZE - 1
NUM_GAIT_JOINTS = len(GAIT_JOINTS)
NUM_CHANNELS = 2 * NUM_JOINTS + 2
MIRROR_PERMUTATION = tuple((i + LEG_SIZE) % NUM_JOINTS for i in range(NUM_JOINTS))


def joint_names(geometry: Geometry) -> tuple[str, ...]:
    """Names of all joints (12)."""
    return _both(geometry.leg_joints)


def motor_names(geometry: Geometry) -> tuple[str, ...]:
    """Names of all motors (10, with soles 12)."""
    last = () if geometry.sole is None else ("ankle_roll",)
    return _both((*geometry.axes.order, "leg_1", "leg_2", *last))


def driven_joints(geometry: Geometry) -> tuple[int, ...]:
    """Indices of the joints that are actuated; there are as many motors."""
    return GAIT_JOINTS if geometry.sole is None else tuple(range(NUM_JOINTS))


def knee_joint_names(geometry: Geometry) -> tuple[str, ...]:
    """Names of the joints of gaits (10): a knee instead of the slide, no upper foot."""
    return _both((*geometry.axes.order, "knee", "ankle"))


def _both(leg: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(f"{side}_{name}" for side in SIDES for name in leg)


def mirror_sign(geometry: Geometry) -> tuple[float, ...]:
    """Signs (12) of joints under reflection at the sagittal plane: −1 for yaw and roll."""
    return tuple(-1.0 if name in LATERAL else 1.0 for name in geometry.leg_joints) * len(SIDES)


# Commands of a robot: velocity of the base in its heading frame [m/s], yaw rate [rad/s].
VELOCITY = ("vx", "vy", "yaw_rate")

GRAVITY = 9.81  # [m/s²], as in MuJoCo

BASE = "base"
FLOOR = "floor"
IMU = "imu"


def velocity_text(velocity: Iterable[float]) -> str:
    """A commanded velocity (vx, vy, yaw rate) as text; a yaw rate of zero is left out."""
    vx, vy, yaw_rate = velocity
    return f"({vx:g}, {vy:g}) m/s" + (f", {yaw_rate:g} rad/s" if yaw_rate else "")


def other_side(side: str) -> str:
    """``right`` for ``left``, and vice versa."""
    return SIDES[1 - SIDES.index(side)]


def foot(side: str) -> str:
    """Name of the foot body and geom of a side."""
    return f"{side}_foot"


def tube(side: str) -> str:
    """Name of the geom of a side's tube."""
    return f"{side}_tube"


def sole(side: str) -> str:
    """Name of the site at the middle of the foot line."""
    return f"{side}_sole"


# Geoms that collide with each other: of the left and the right leg, and of the legs with the base.
LEG_PAIRS = tuple(
    (f"left_{left}", f"right_{right}")
    for left, right in (
        ("foot", "foot"),
        ("tube", "tube"),
        ("foot", "tube"),
        ("tube", "foot"),
        ("upper_foot", "upper_foot"),
        ("upper_foot", "tube"),
        ("tube", "upper_foot"),
        ("hip", "tube"),
        ("tube", "hip"),
    )
)
BASE_PAIRS = tuple((tube(side), BASE) for side in SIDES)


def channels(geometry: Geometry) -> tuple[str, ...]:
    """Names of the channels of a gait sample (26), which the guide compares with observations."""
    joints = joint_names(geometry)
    positions, velocities = ([f"{name}.{x}" for name in joints] for x in ("position", "velocity"))
    return (*positions, *velocities, "base.vx", "base.vy")


def channel_units(geometry: Geometry) -> tuple[str, ...]:
    """Units of ``channels``; a knee is named ``slide``."""
    slide = "rad" if geometry.knee else "m"
    units = [slide if name == "slide" else "rad" for name in geometry.leg_joints] * len(SIDES)
    return (*units, *(f"{unit}/s" for unit in units), "m/s", "m/s")
