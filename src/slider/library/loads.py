"""What gaits ask of the drives, against the robot's limits; and how high they lift their feet."""

from dataclasses import dataclass

import numpy as np

from slider.library.contents import LibraryContents, Robot
from slider.robot.kinematics import foot_ends, rotation_from_quaternion
from slider.robot.names import JOINTS, NUM_JOINTS

SLIDES = tuple(i for i, name in enumerate(JOINTS) if name.endswith("slide"))
_ROTARY = tuple(i for i in range(NUM_JOINTS) if i not in SLIDES)


@dataclass(frozen=True)
class Peak:
    """Greatest magnitude of a quantity over a walk, and the limit it is held against."""

    quantity: str
    joint: str
    value: float
    limit: float
    unit: str

    @property
    def share(self) -> float:
        """Value / limit [-]."""
        return self.value / self.limit


def effort_shares(library: LibraryContents) -> np.ndarray:
    """Greatest |effort| / limit (G, 12) over each walk [-]; 0 for joints without a drive."""
    peak = np.abs(library.arrays["efforts"]).max(axis=1)
    limit = library.robot.joint_limits("effort")
    return np.where(limit > 0, peak / np.where(limit > 0, limit, 1.0), 0.0)


def speed_shares(library: LibraryContents) -> np.ndarray:
    """Greatest |speed| / limit (G, 12) over each walk [-]."""
    speeds = library.arrays["samples"][..., NUM_JOINTS : 2 * NUM_JOINTS]
    return np.abs(speeds).max(axis=1) / library.robot.joint_limits("speed")


def peak_torque_share(library: LibraryContents) -> np.ndarray:
    """Greatest torque / limit (G,) over all rotary drives [-]."""
    return effort_shares(library)[:, _ROTARY].max(axis=1)


def slide_force_share(library: LibraryContents) -> np.ndarray:
    """Greatest slide force / limit (G,) [-]."""
    return effort_shares(library)[:, SLIDES].max(axis=1)


def slide_speed_share(library: LibraryContents) -> np.ndarray:
    """Greatest slide speed / limit (G,) [-]."""
    return speed_shares(library)[:, SLIDES].max(axis=1)


def peaks(library: LibraryContents, gait: int) -> list[Peak]:
    """Torque, rotary speed, slide force and slide speed of one gait, each at its worst joint."""
    return [
        _peak("torque", effort_shares(library)[gait], _ROTARY, "effort", "N m", library.robot),
        _peak("speed", speed_shares(library)[gait], _ROTARY, "speed", "rad/s", library.robot),
        _peak("slide force", effort_shares(library)[gait], SLIDES, "effort", "N", library.robot),
        _peak("slide speed", speed_shares(library)[gait], SLIDES, "speed", "m/s", library.robot),
    ]


def _peak(
    quantity: str, shares: np.ndarray, joints: tuple[int, ...], kind: str, unit: str, robot: Robot
) -> Peak:
    worst = max(joints, key=lambda joint: shares[joint])
    limit = robot.joint_limits(kind)[worst]
    return Peak(quantity, JOINTS[worst], float(shares[worst] * limit), float(limit), unit)


def foot_heights(library: LibraryContents, gait: int) -> np.ndarray:
    """Height of the lower end of each foot line (S, 2), left and right, above the ground [m]."""
    base = library.arrays["base"][gait]
    joints = library.arrays["samples"][gait][:, :NUM_JOINTS]
    ends = foot_ends(library.robot.geometry, rotation_from_quaternion(base[:, 3:7]), joints)
    return base[:, 2:3] + ends[..., 2].min(axis=2)


def clearance(library: LibraryContents, gait: int) -> float:
    """Height of the lower end of the swing foot at mid-step, the lower of the two steps [m]."""
    heights = foot_heights(library, gait)
    per_step = len(heights) // 2
    middle = per_step // 2
    return float(min(heights[middle, 1], heights[per_step + middle, 0]))
