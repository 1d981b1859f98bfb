"""Measures of gaits: use of the motors, clearance of the feet, jumps between neighbours."""

from dataclasses import dataclass

import numpy as np

from slider.library.reader import GaitLibrary
from slider.robot.kinematics import foot_ends, rotation_from_quaternion
from slider.robot.names import EXTENSION, LEG_SIZE, NUM_JOINTS
from slider.robot.transmission import Transmission

_SPEEDS = slice(NUM_JOINTS, 2 * NUM_JOINTS)


def motor_shares(library: GaitLibrary) -> tuple[np.ndarray, np.ndarray]:
    """Greatest torque / limit and voltage / bus voltage (G, 10) of all motors over each walk."""
    speeds = library.arrays["samples"][..., _SPEEDS]
    torque, voltage = Transmission.of(library.robot).shares(library.arrays["efforts"], speeds)
    return np.abs(torque).max(axis=1), np.abs(voltage).max(axis=1)


def slide_speed(library: GaitLibrary) -> np.ndarray:
    """Greatest speed (G,) of the slides [m/s]."""
    speeds = library.arrays["samples"][..., _SPEEDS]
    return np.abs(speeds[..., EXTENSION::LEG_SIZE]).max(axis=(1, 2))


def foot_heights(library: GaitLibrary, gait: int) -> np.ndarray:
    """Height of the lower end of each foot line (S, 2), left and right, above the ground [m]."""
    base = library.arrays["base"][gait]
    joints = library.arrays["samples"][gait][:, :NUM_JOINTS]
    ends = foot_ends(library.robot.geometry, rotation_from_quaternion(base[:, 3:7]), joints)
    return base[:, 2:3] + ends[..., 2].min(axis=2)


def clearance(library: GaitLibrary, gait: int) -> float:
    """Height of the lower end of the swing foot at mid-step, the lower of the two steps [m]."""
    left, right = np.split(foot_heights(library, gait), 2)
    middle = len(left) // 2
    return float(min(left[middle, 1], right[middle, 0]))


@dataclass(frozen=True)
class Smoothness:
    """Pairs (P, 2) of neighbouring gaits, and the greatest jump (P, C) of each channel.

    A jump is the largest |difference| of the samples / range of the channel in the library [-].
    """

    pairs: np.ndarray
    jumps: np.ndarray

    @property
    def largest(self) -> float:
        """Greatest jump of any pair and channel [-]; 0 where nothing has a neighbour."""
        return float(self.jumps.max(initial=0.0))

    @property
    def worst(self) -> tuple[int, int, int]:
        """First gait, second gait and channel of the greatest jump."""
        pair, channel = np.unravel_index(self.jumps.argmax(), self.jumps.shape)
        first, second = self.pairs[pair]
        return int(first), int(second), int(channel)


def smoothness(velocities: np.ndarray, samples: np.ndarray) -> Smoothness:
    """Jumps between neighbours of gaits with velocities (G, 3) and channels (G, S, C).

    Each channel is divided by its range over all gaits and samples: 0.1 is a tenth of it. A
    constant channel has no jumps.
    """
    pairs = neighbours(velocities)
    extent = np.ptp(samples, axis=(0, 1))
    scale = np.where(extent > 0, extent, np.inf)
    change = np.abs(samples[pairs[:, 1]] - samples[pairs[:, 0]]).max(axis=1)
    return Smoothness(pairs, change / scale)


def neighbours(velocities: np.ndarray) -> np.ndarray:
    """Pairs (P, 2) of gaits that follow one another along one axis of the velocity.

    No other gait lies between the two, but holes may.
    """
    pairs = []
    for along, *fixed in ((0, 1, 2), (1, 0, 2), (2, 0, 1)):
        order = np.lexsort(velocities.T[[along, *fixed]])
        same = (np.diff(velocities[order][:, fixed], axis=0) == 0).all(axis=1)
        pairs.append(np.stack([order[:-1], order[1:]], axis=1)[same])
    return np.concatenate(pairs)
