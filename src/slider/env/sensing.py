"""White noise of what a controller receives about the robot."""

from dataclasses import replace

import numpy as np

from slider.config.env import SensingConfig
from slider.core.arrays import Array, asarray, namespace
from slider.env.starts import multiply_quaternions
from slider.env.state import RobotState
from slider.robot.kinematics import rotation_from_quaternion, turn_to_heading, yaw_of
from slider.robot.names import JOINTS, NUM_JOINTS

NUMBERS = 2 * NUM_JOINTS + 10  # standard normal numbers per robot
SLIDES = np.array([name.endswith("slide") for name in JOINTS])


def with_noise(state: RobotState, config: SensingConfig, normal: Array) -> RobotState:
    """The state with noise of standard normal numbers (N, 34).

    Terminations and metrics use the true state. So do rewards, but for the low-passed velocity and
    the heading error, which are the agent's own.

    The orientation is turned about the base's axes, and everything that follows from it as well.
    The horizontal place of the base, feet and contacts are as they are.
    """
    xp, base = namespace(normal), normal[:, 2 * NUM_JOINTS :]
    positions, velocities = normal[:, :NUM_JOINTS], normal[:, NUM_JOINTS : 2 * NUM_JOINTS]
    quaternion = turned(state.quaternion, config.orientation * base[:, :3])
    rotation = rotation_from_quaternion(quaternion)
    yaw = yaw_of(rotation)
    linear = state.linear_velocity + config.linear_velocity * base[:, 3:6]
    position = 1.0 * state.base_position
    position[:, 2] += config.base_height * base[:, 9]
    spread = np.where(SLIDES, config.slide_position, config.joint_position)
    rate = np.where(SLIDES, config.slide_velocity, config.joint_velocity)
    spread, rate = asarray(spread, normal), asarray(rate, normal)
    return replace(
        state,
        base_position=position,
        quaternion=quaternion,
        rotation=rotation,
        yaw=yaw,
        linear_velocity=linear,
        angular_velocity=state.angular_velocity + config.angular_velocity * base[:, 6:9],
        heading_velocity=turn_to_heading(xp.einsum("nij,nj->ni", rotation, linear), yaw),
        gravity=-rotation[:, 2, :],
        joint_positions=state.joint_positions + spread * positions,
        joint_velocities=state.joint_velocities + rate * velocities,
    )


def turned(quaternion: Array, angles: Array) -> Array:
    """Orientations (N, 4) turned by small angles (N, 3) [rad] about the body's own axes."""
    xp = namespace(angles)
    small = xp.concat([xp.ones_like(angles[:, :1]), 0.5 * angles], axis=1)
    small /= xp.linalg.vector_norm(small, axis=1, keepdims=True)
    return multiply_quaternions(quaternion, small)
