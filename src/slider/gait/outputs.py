"""Coordinates x of the virtual constraints, and their outputs y = H (x − x_d).

x (12,): roll and yaw of the stance foot's line, then the ten driven joints of the prismatic legs,
stance leg first, reflected in right stance. The line foot lies flat, so that roll is unactuated
and yaw is constant during a step.
"""

import numpy as np

from slider.config.robot import HIP_JOINTS, Geometry
from slider.robot.names import ANKLE, EXTENSION, GAIT_JOINTS, mirror_sign
from slider.robot.names import LEG_GAIT_JOINTS as LEG
from slider.robot.names import NUM_GAIT_JOINTS as NUM_JOINTS

ROLL, YAW, JOINTS = 0, 1, 2  # indices in x; the joints follow
NUM_COORDINATES = JOINTS + NUM_JOINTS
STANCE, SWING = JOINTS, JOINTS + LEG  # first joint of each leg in the coordinates

_HIP, _PITCH = len(HIP_JOINTS), HIP_JOINTS.index("hip_pitch")
_DRIVEN = np.array(GAIT_JOINTS)
_SWAP = np.r_[LEG:NUM_JOINTS, 0:LEG]


def output_matrix(geometry: Geometry) -> np.ndarray:
    """H (10, 12), stance leg first; outputs of a hip are yaw, roll, pitch, whatever its order.

    Yaw, roll and pitch of the torso, stance slide or knee, stance ankle; yaw, roll and pitch of the
    swing leg, swing slide or knee, pitch of the swing foot. Angles are small and, but for knee and
    ankle, relative to ground and heading: the torso stays upright where the stance foot rolls.
    """
    matrix = np.zeros((NUM_JOINTS, NUM_COORDINATES))
    matrix[:, JOINTS:] = np.eye(NUM_JOINTS)
    places = [geometry.axes.order.index(name) for name in HIP_JOINTS]
    for leg in (0, LEG):
        matrix[leg : leg + _HIP] = matrix[leg + np.array(places)]
    # Each joint turns what is below it about its axis; yaw, roll and pitch are about z, x and y.
    stance, swing = (
        np.array([(not joint.slides) * joint.axis[[2, 0, 1]] for joint in geometry.leg(lateral)]).T
        for lateral in (1.0, -1.0)
    )
    torso = np.zeros((_HIP, NUM_COORDINATES))
    torso[0, YAW] = torso[1, ROLL] = 1.0
    torso[:, STANCE : STANCE + LEG] = -stance
    matrix[:_HIP] = torso
    matrix[LEG : LEG + _HIP] = torso
    matrix[LEG : LEG + _HIP, SWING : SWING + _HIP] += swing[:, :_HIP]
    matrix[LEG + ANKLE] = matrix[LEG + _PITCH]
    matrix[LEG + ANKLE, SWING + EXTENSION :] += swing[_PITCH, EXTENSION:]
    return matrix


def driven_signs(geometry: Geometry) -> np.ndarray:
    """Signs (10,) of the reflection of the driven joints."""
    return np.array(mirror_sign(geometry))[_DRIVEN]


def stance_first(joints: np.ndarray, right: np.ndarray, signs: np.ndarray) -> np.ndarray:
    """Reorder driven joints (n, 10) from left leg first to stance leg first, reflected; and back.

    ``right`` (n,): whether the right foot is the stance foot; ``signs`` (10,) of the reflection.
    """
    return np.where(right[:, None], signs * joints[:, _SWAP], joints)


def stance_selection(right: np.ndarray, signs: np.ndarray) -> np.ndarray:
    """Matrices (n, 10, 12) from all joints (12,) to the driven ones, stance leg first."""
    rows = np.arange(NUM_JOINTS)
    selections = np.zeros((2, NUM_JOINTS, len(_SWAP) + 2))
    selections[0, rows, _DRIVEN] = 1.0
    selections[1, rows, _DRIVEN[_SWAP]] = signs
    return selections[right.astype(int)]
