"""Coordinates that virtual constraints hold, and their outputs y = H (x − x_d).

x are roll and yaw of the stance foot's line and the ten driven joints of the prismatic legs, the
stance leg first, reflected in right stance (12,). The line foot lies flat, so that roll is the
coordinate without an actuator and yaw is constant during a step. All choices of H have the same
zero set on the gait; they differ in what a change of roll or heading does to it.
"""

import numpy as np

from slider.robot.names import ACTUATED, LEG_MIRROR_SIGN, LEG_MOTORS, SIDES

LEG = len(LEG_MOTORS)  # driven joints of a leg
NUM_JOINTS = LEG * len(SIDES)
ROLL, YAW, JOINTS = 0, 1, 2  # places in the coordinates; joints follow
NUM_COORDINATES = JOINTS + NUM_JOINTS
STANCE, SWING = JOINTS, JOINTS + LEG  # first joint of each leg in the coordinates

_HIP = 3  # yaw, roll and pitch of a hip turn in this order
_PITCH, EXTENSION, ANKLE = 2, 3, 4
_DRIVEN = np.array(ACTUATED)
_SIGN = np.array(LEG_MIRROR_SIGN[:LEG] * len(SIDES))
_SWAP = np.r_[LEG:NUM_JOINTS, 0:LEG]


def output_matrix(kind: str, knee: bool = False) -> np.ndarray:
    """H (10, 12) of legs that slide, or have a ``knee``.

    ``joints``: the joints themselves. ``absolute``: yaw, roll and pitch of torso, swing leg and
    (pitch only) swing foot with respect to ground and heading in place of their joints (small
    angles), both slides or knees, the stance ankle and the swing hip's share; the torso then stays
    upright where the stance foot rolls.
    """
    matrix = np.zeros((NUM_JOINTS, NUM_COORDINATES))
    matrix[:, JOINTS:] = np.eye(NUM_JOINTS)
    if kind == "joints":
        return matrix
    torso = np.zeros((_HIP, NUM_COORDINATES))
    torso[0, YAW] = torso[1, ROLL] = 1.0
    torso[np.arange(_HIP), STANCE + np.arange(_HIP)] = -1.0
    torso[_PITCH, STANCE + ANKLE] = -1.0
    if knee:
        torso[_PITCH, STANCE + EXTENSION] = -1.0
    matrix[:_HIP] = torso
    matrix[LEG : LEG + _HIP] += torso
    matrix[LEG + ANKLE] += matrix[LEG + _PITCH]
    if knee:
        matrix[LEG + ANKLE, SWING + EXTENSION] += 1.0
    return matrix


def stance_first(joints: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Reorder driven joints (n, 10) from left leg first to stance leg first, reflected; and back.

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
