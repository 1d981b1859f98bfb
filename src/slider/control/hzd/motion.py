"""Measurements of robots in stance for steps by virtual constraints: coordinates, hip, section.

All is in the frame of the stance foot, reflected in right stance. ``stance`` (n,) are the feet.
"""

from dataclasses import dataclass

import numpy as np

from slider.control.whole_body.memory import RIGHT
from slider.control.whole_body.model import NUM_DOFS, Dynamics
from slider.control.whole_body.tasks import pitch_and_yaw, point_velocity, wrapped
from slider.gait.outputs import JOINTS, NUM_COORDINATES, YAW, stance_first, stance_selection
from slider.robot.kinematics import turn_to_heading, yaw_of
from slider.robot.names import ACTUATED

_DRIVEN = np.array(ACTUATED)
_ROWS = np.zeros((2, NUM_COORDINATES, NUM_DOFS))  # in left and right stance: of the driven joints
_ROWS[:, JOINTS:, 6:] = stance_selection(np.array([False, True]))


@dataclass(frozen=True)
class Motion:
    """Coordinates of n robots in stance: roll, yaw and driven joints, stance leg first.

    Attributes:
        x, rate: (n, 12).
        jacobian: (n, 12, 18), ẍ = jacobian q̈ up to what q̇ adds.
    """

    x: np.ndarray
    rate: np.ndarray
    jacobian: np.ndarray


def side_of(stance: np.ndarray) -> np.ndarray:
    """+1 in left stance, −1 in right stance (n,)."""
    return np.where(stance == RIGHT, -1.0, 1.0)


def motion(
    dynamics: Dynamics, stance: np.ndarray, heading: np.ndarray, yaw_rate: np.ndarray
) -> Motion:
    """Coordinates; yaw counts from ``heading`` (n,) [rad], which turns with ``yaw_rate`` (n,)."""
    rows, right, side = np.arange(len(stance)), stance == RIGHT, side_of(stance)
    rotation = dynamics.foot_rotations[rows, stance]
    angular = dynamics.foot_jacobians[rows, stance, 3:]
    axes = np.stack([rotation[:, :, 0], pitch_and_yaw(rotation)[:, 1]], axis=1)
    jacobian = _ROWS[right.astype(int)]
    np.multiply(side[:, None, None], axes @ angular, out=jacobian[:, :JOINTS])
    roll = side * np.arcsin(np.clip(rotation[:, 2, 1], -1.0, 1.0))
    yaw = side * wrapped(yaw_of(rotation) - heading)
    joints = stance_first(dynamics.joints[:, _DRIVEN], right)
    rate = point_velocity(jacobian, dynamics.qvel)
    rate[:, YAW] -= side * yaw_rate
    return Motion(np.concatenate([roll[:, None], yaw[:, None], joints], axis=1), rate, jacobian)


def hip(dynamics: Dynamics, stance: np.ndarray, line: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Place (n,) [m] and velocity [m/s] of the base along the foot's line, of yaw ``line`` (n,)."""
    sole = dynamics.foot_positions[np.arange(len(stance)), stance, :2]
    place = turn_to_heading(dynamics.base_position[:, :2] - sole, line)[:, 0]
    return place, turn_to_heading(dynamics.qvel[:, :2], line)[:, 0]


def section(dynamics: Dynamics, stance: np.ndarray) -> np.ndarray:
    """ξ (n, 4) of the centre of mass: lateral place, horizontal velocity, forward place."""
    rows = np.arange(len(stance))
    yaw = yaw_of(dynamics.foot_rotations[rows, stance])
    place = dynamics.com[:, :2] - dynamics.foot_positions[rows, stance, :2]
    place, speed = (turn_to_heading(v, yaw) for v in (place, dynamics.com_velocity[:, :2]))
    side = side_of(stance)
    lateral = [side * place[:, 1], side * speed[:, 1]]
    return np.stack([*lateral, speed[:, 0], place[:, 0]], axis=1)
