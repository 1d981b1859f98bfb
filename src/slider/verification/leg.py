"""Inverse kinematics of a prismatic leg that carries its foot level along a heading."""

import numpy as np

from slider.config.robot import Geometry
from slider.robot import names


def level_leg(
    geometry: Geometry,
    side: str,
    base: tuple[np.ndarray, np.ndarray],
    sole: np.ndarray,
    heading: np.ndarray,
) -> np.ndarray:
    """Hip yaw, roll and pitch [rad], slide [m], ankle [rad] (5,) of a foot line along a heading.

    The leg turns pitch and ankle about one axis; it is perpendicular to the foot line and to the
    way from the sole to the hip, so that yaw and roll follow from it in closed form.

    Args:
        geometry: of the robot.
        side: the leg's.
        base: position (3,) [m] and rotation to world (3, 3).
        sole: middle of the foot line (3,) [m].
        heading: unit vector (3,) along the foot line, towards the toe.
    """
    position, rotation = base
    sign = 1.0 if side == names.SIDES[0] else -1.0
    hip = position + rotation @ np.array([0.0, sign * geometry.hip_offset, 0.0])
    axis = _cross(hip - sole, heading)
    axis /= np.linalg.norm(axis)
    ankle = sole + geometry.ankle_height * _cross(heading, axis)
    turn = rotation.T @ axis
    roll = np.arcsin(np.clip(turn[2], -1.0, 1.0))
    yaw = np.arctan2(-turn[0], turn[1])
    to_leg = _about_x(roll).T @ _about_z(yaw).T @ rotation.T
    reach, toe = to_leg @ (ankle - hip), to_leg @ heading
    pitch = np.arctan2(-reach[0], -reach[2])
    level = np.arctan2(-toe[2], toe[0])
    slide = np.linalg.norm(reach) - geometry.leg_length
    return np.array([yaw, roll, pitch, slide, level - pitch])


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """np.cross for two vectors (3,), which it does ten times slower."""
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def _about_x(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def _about_z(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
