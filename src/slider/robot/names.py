"""Names of joints, bodies, sites and sensors: defined once, used everywhere.

Joint order: left leg, then right leg, each from hip to foot. x forward, y left, z up.
"""

SIDES = ("left", "right")
LEG_JOINTS = ("hip_yaw", "hip_roll", "hip_pitch", "slide", "ankle", "upper_foot")
JOINTS = tuple(f"{side}_{joint}" for side in SIDES for joint in LEG_JOINTS)
NUM_JOINTS = len(JOINTS)
PASSIVE_LEG_JOINTS = ("upper_foot",)
ACTUATED = tuple(i for i, name in enumerate(JOINTS) if not name.endswith(PASSIVE_LEG_JOINTS))

# The virtual-knee model has a revolute knee in place of the slide and no upper foot.
KNEE_LEG_JOINTS = ("hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle")
KNEE_JOINTS = tuple(f"{side}_{joint}" for side in SIDES for joint in KNEE_LEG_JOINTS)

# Reflection at the sagittal plane: swap the legs, then flip yaw and roll.
MIRROR_PERMUTATION = tuple((i + len(LEG_JOINTS)) % NUM_JOINTS for i in range(NUM_JOINTS))
LEG_MIRROR_SIGN = (-1.0, -1.0, 1.0, 1.0, 1.0, 1.0)
MIRROR_SIGN = LEG_MIRROR_SIGN * len(SIDES)

BASE = "base"
FLOOR = "floor"
IMU = "imu"


def foot(side: str) -> str:
    """Name of the foot body and geom of a side."""
    return f"{side}_foot"


def sole(side: str) -> str:
    """Name of the site at the middle of the foot line."""
    return f"{side}_sole"


# Channels of a gait sample and of the observation's part that the guide compares (26).
CHANNELS = (
    *(f"{name}.position" for name in JOINTS),
    *(f"{name}.velocity" for name in JOINTS),
    "base.vx",
    "base.vy",
)
CHANNEL_UNITS = (
    *("m" if name.endswith("slide") else "rad" for name in JOINTS),
    *("m/s" if name.endswith("slide") else "rad/s" for name in JOINTS),
    "m/s",
    "m/s",
)
