"""Coordinates of the virtual constraints from those of the robot: the stance leg first."""

import numpy as np

from slider.gait.outputs import (
    ANKLE,
    JOINTS,
    LEG,
    NUM_COORDINATES,
    NUM_JOINTS,
    OUTPUTS,
    ROLL,
    STANCE,
    SWING,
    YAW,
    output_matrix,
)
from slider.robot.names import ACTUATED, LEG_MIRROR_SIGN, SIDES

__all__ = [
    "ANKLE",
    "JOINTS",
    "LEG",
    "NUM_COORDINATES",
    "NUM_JOINTS",
    "OUTPUTS",
    "ROLL",
    "STANCE",
    "SWING",
    "YAW",
    "output_matrix",
    "stance_first",
    "stance_selection",
]

_DRIVEN = np.array(ACTUATED)
_SIGN = np.array(LEG_MIRROR_SIGN[:LEG] * len(SIDES))
_SWAP = np.r_[LEG:NUM_JOINTS, 0:LEG]


def stance_first(joints: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Driven joints (n, 10) of left and right leg as the stance leg sees them, and back.

    Args:
        joints: positions, velocities or torques, left leg first.
        right: (n,) whether the right foot is the stance foot.
    """
    return np.where(right[:, None], _SIGN * joints[:, _SWAP], joints)


def stance_selection(right: np.ndarray) -> np.ndarray:
    """Matrices (n, 10, 12) from all joints (12,) to the driven ones, stance leg first."""
    rows = np.arange(NUM_JOINTS)
    selections = np.zeros((2, NUM_JOINTS, len(_SWAP) + 2))
    selections[0, rows, _DRIVEN] = 1.0
    selections[1, rows, _DRIVEN[_SWAP]] = _SIGN
    return selections[right.astype(int)]
