"""Names of joints, bodies, sites and sensors, and gravity: defined once, used everywhere.

Joint order: left leg, then right leg, each from hip to foot. x forward, y left, z up.
"""

from collections.abc import Iterable

from slider.config.robot import LEG_JOINTS

SIDES = ("left", "right")
FOOT_ENDS = ("heel", "toe")
JOINTS = tuple(f"{side}_{joint}" for side in SIDES for joint in LEG_JOINTS)
NUM_JOINTS = len(JOINTS)
PASSIVE_LEG_JOINTS = ("upper_foot",)
ACTUATED = tuple(i for i, name in enumerate(JOINTS) if not name.endswith(PASSIVE_LEG_JOINTS))

# Motors: one per hip joint; two for slide and ankle, one each or both by a capstan.
LEG_MOTORS = ("hip_yaw", "hip_roll", "hip_pitch", "leg_1", "leg_2")
MOTORS = tuple(f"{side}_{motor}" for side in SIDES for motor in LEG_MOTORS)

# The virtual-knee model has a revolute knee in place of the slide and no upper foot.
KNEE_LEG_JOINTS = ("hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle")
KNEE_JOINTS = tuple(f"{side}_{joint}" for side in SIDES for joint in KNEE_LEG_JOINTS)

# Reflection at the sagittal plane: swap the legs, then flip yaw and roll.
MIRROR_PERMUTATION = tuple((i + len(LEG_JOINTS)) % NUM_JOINTS for i in range(NUM_JOINTS))
LEG_MIRROR_SIGN = (-1.0, -1.0, 1.0, 1.0, 1.0, 1.0)
MIRROR_SIGN = LEG_MIRROR_SIGN * len(SIDES)

# What a robot is commanded to: velocity of the base in its heading frame [m/s], yaw rate [rad/s].
VELOCITY = ("vx", "vy", "yaw_rate")

GRAVITY = 9.81  # [m/s²], as in MuJoCo

BASE = "base"
FLOOR = "floor"
IMU = "imu"


def velocity_text(velocity: Iterable[float]) -> str:
    """A commanded velocity (vx, vy, yaw rate) in words; a yaw rate of zero is left out."""
    vx, vy, yaw_rate = velocity
    return f"({vx:g}, {vy:g}) m/s" + (f", {yaw_rate:g} rad/s" if yaw_rate else "")


def other_side(side: str) -> str:
    """``right`` of ``left``, and back."""
    return SIDES[1 - SIDES.index(side)]


def leg_joint(joint: str) -> str:
    """Name within the leg of a joint, such as ``hip_yaw`` of ``left_hip_yaw``."""
    return joint.split("_", 1)[1]


def foot(side: str) -> str:
    """Name of the foot body and geom of a side."""
    return f"{side}_foot"


def tube(side: str) -> str:
    """Name of the geom of the leg's tube of a side."""
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

# Channels of a gait sample and of the observation's part that the guide compares (26).
CHANNELS = (
    *(f"{name}.position" for name in JOINTS),
    *(f"{name}.velocity" for name in JOINTS),
    "base.vx",
    "base.vy",
)
NUM_CHANNELS = len(CHANNELS)
CHANNEL_UNITS = (
    *("m" if name.endswith("slide") else "rad" for name in JOINTS),
    *("m/s" if name.endswith("slide") else "rad/s" for name in JOINTS),
    "m/s",
    "m/s",
)
"""Of legs that slide."""


def channel_units(has_knee: bool) -> tuple[str, ...]:
    """Units of ``CHANNELS``; a knee has the place of the slide."""
    turning = ("rad",) * NUM_JOINTS + ("rad/s",) * NUM_JOINTS
    return turning + CHANNEL_UNITS[len(turning) :] if has_knee else CHANNEL_UNITS
