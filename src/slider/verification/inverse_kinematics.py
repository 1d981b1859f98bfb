"""Joints of a leg whose foot line is at a place and along a heading, on any hip.

By the Levenberg-Marquardt method with the damping of Sugihara, "Solvability-unconcerned inverse
kinematics by the Levenberg-Marquardt method", IEEE Transactions on Robotics 2011.
"""

import numpy as np

from slider.config.robot import Geometry, LegJoint
from slider.robot.names import EXTENSION, SIDES

_ITERATIONS, _CLOSE, _DAMPING = 30, 1e-12, 1e-9  # [rad, m]


def level_leg(
    geometry: Geometry,
    side: str,
    base: tuple[np.ndarray, np.ndarray],
    sole: np.ndarray,
    heading: np.ndarray,
    start: np.ndarray,
) -> np.ndarray:
    """Hip, slide or knee, and ankle (5,) [rad, m] of a foot line on a heading; else near there.

    Args:
        geometry, side: of the robot; the leg's.
        base: position (3,) [m] and rotation to world (3, 3).
        sole: middle of the foot line (3,) [m].
        heading: unit vector (3,) along the foot line, towards the toe.
        start: joints (5,) to begin with.
    """
    lateral = 1.0 if side == SIDES[0] else -1.0
    joints = geometry.leg(lateral)
    across = np.linalg.svd(heading[None])[2][1:]  # (2, 3), perpendicular to the heading
    q = start.copy()
    for _ in range(_ITERATIONS):
        place, rotation, jacobian = _foot(joints, base, q, geometry.ankle_height)
        toe = rotation[:, 0]
        turned = np.array([_cross(axis, toe) for axis in jacobian[3:].T]).T
        rows = np.concatenate([jacobian[:3], across @ turned])
        error = np.append(place - sole, across @ toe)
        damped = rows.T @ rows + (error @ error + _DAMPING) * np.eye(len(q))
        step = np.linalg.solve(damped, rows.T @ error)
        q -= step
        if np.abs(step).max() < _CLOSE:
            break
    if geometry.knee is not None:  # at most straight
        bent = np.sign(geometry.bend) * (q[EXTENSION] + geometry.bend)
        q[EXTENSION] = np.sign(geometry.bend) * max(bent, 0.0) - geometry.bend
    return q


def _foot(
    joints: list[LegJoint], base: tuple[np.ndarray, np.ndarray], q: np.ndarray, ankle_height: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sole (3,) [m], rotation to world (3, 3) and Jacobian (6, 5) of a leg's foot."""
    (place, rotation), axes, places = base, [], []
    for (_, offset, axis, slides), position in zip(joints, q, strict=True):
        place = place + rotation @ offset
        axes.append(rotation @ axis)
        places.append(place)
        if slides:
            place = place + position * axes[-1]
        else:
            rotation = _turned(axis, position, rotation)
    sole = place - ankle_height * rotation[:, 2]
    jacobian = np.zeros((6, len(q)))
    for column, ((*_, slides), axis, joint) in enumerate(zip(joints, axes, places, strict=True)):
        jacobian[:3, column] = axis if slides else _cross(axis, sole - joint)
        jacobian[3:, column] = 0.0 if slides else axis
    return sole, rotation, jacobian


def _turned(axis: np.ndarray, angle: float, rotation: np.ndarray) -> np.ndarray:
    """A rotation (3, 3) to world, followed by a turn about an axis of its own frame."""
    cross = np.cross(np.eye(3), axis)
    turn = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross)
    return rotation @ turn


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """np.cross for two vectors (3,), which it does ten times slower."""
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )
