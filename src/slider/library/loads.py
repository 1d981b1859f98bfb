"""What gaits ask of the motors, against their limits; and how high they lift their feet."""

from dataclasses import dataclass

import numpy as np

from slider.library.reader import GaitLibrary
from slider.robot.kinematics import foot_ends, rotation_from_quaternion
from slider.robot.names import JOINTS, MOTORS, NUM_JOINTS
from slider.robot.transmission import Transmission

_SPEEDS = slice(NUM_JOINTS, 2 * NUM_JOINTS)
_SLIDES = [i for i in range(NUM_JOINTS) if JOINTS[i].endswith("slide")]


@dataclass(frozen=True)
class Peak:
    """Greatest magnitude of a motor's quantity over a walk, and the limit it is held against."""

    quantity: str
    motor: str
    value: float
    limit: float
    unit: str

    @property
    def share(self) -> float:
        """Value / limit [-]."""
        return self.value / self.limit


def motor_torques(library: GaitLibrary, gait: int) -> np.ndarray:
    """Torques (S, 10) of all motors over a walk [N m]."""
    return Transmission.of(library.robot).torques(library.arrays["efforts"][gait])


def motor_shares(library: GaitLibrary) -> tuple[np.ndarray, np.ndarray]:
    """Greatest torque / limit and voltage / bus voltage (G, 10) of all motors over each walk."""
    speeds = library.arrays["samples"][..., _SPEEDS]
    torque, voltage = Transmission.of(library.robot).shares(library.arrays["efforts"], speeds)
    return np.abs(torque).max(axis=1), np.abs(voltage).max(axis=1)


def torque_share(library: GaitLibrary) -> np.ndarray:
    """Greatest torque / limit (G,) over all motors [-]."""
    return motor_shares(library)[0].max(axis=1)


def voltage_share(library: GaitLibrary) -> np.ndarray:
    """Greatest share (G,) of the torque-speed lines over all motors [-]."""
    return motor_shares(library)[1].max(axis=1)


def slide_speed(library: GaitLibrary) -> np.ndarray:
    """Greatest speed (G,) of the slides [m/s]."""
    return np.abs(library.arrays["samples"][..., _SPEEDS][..., _SLIDES]).max(axis=(1, 2))


def peaks(library: GaitLibrary, gait: int) -> list[Peak]:
    """Torque [N m] and share of the torque-speed line [-] of one gait, each at its worst motor."""
    torque, voltage = (shares[gait] for shares in motor_shares(library))
    worst, fastest = int(torque.argmax()), int(voltage.argmax())
    limit = float(Transmission.of(library.robot).torque[worst])
    return [
        Peak("torque", MOTORS[worst], float(torque[worst] * limit), limit, "N m"),
        Peak("voltage", MOTORS[fastest], float(voltage[fastest]), 1.0, "of the bus"),
    ]


def foot_heights(library: GaitLibrary, gait: int) -> np.ndarray:
    """Height of the lower end of each foot line (S, 2), left and right, above the ground [m]."""
    base = library.arrays["base"][gait]
    joints = library.arrays["samples"][gait][:, :NUM_JOINTS]
    ends = foot_ends(library.robot.geometry, rotation_from_quaternion(base[:, 3:7]), joints)
    return base[:, 2:3] + ends[..., 2].min(axis=2)


def clearance(library: GaitLibrary, gait: int) -> float:
    """Height of the lower end of the swing foot at mid-step, the lower of the two steps [m]."""
    heights = foot_heights(library, gait)
    per_step = len(heights) // 2
    middle = per_step // 2
    return float(min(heights[middle, 1], heights[per_step + middle, 0]))
