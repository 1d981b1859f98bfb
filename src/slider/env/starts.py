"""Starting states of robots: at rest with noise, or on a reference gait."""

from typing import Any

import numpy as np

from slider.config.env import StartNoise
from slider.config.robot import RobotConfig
from slider.core.arrays import Array, asarray, namespace, zeros
from slider.robot.kinematics import (
    quaternion_from_tilt,
    rotation_from_quaternion,
    standing_height,
)
from slider.robot.mjcf import nominal_qpos
from slider.robot.names import EXTENSION, LEG_SIZE, NUM_JOINTS

# For checks during training and export; that of evaluations is configured, by default the same.
USUAL_NOISE = StartNoise(
    joint_position=0.02,
    slide_position=0.005,
    tilt=0.03,
    linear_velocity=0.0,
    angular_velocity=0.0,
    joint_velocity=0.0,
)
NUMPY = np.zeros(0)
SLIDES = np.arange(NUM_JOINTS) % LEG_SIZE == EXTENSION  # or knees


def at_rest(
    robot: RobotConfig, noise: StartNoise, rng: Any, count: int, like: Array = NUMPY
) -> tuple[Array, Array]:
    """Positions (count, 19) and velocities (count, 18) about the nominal pose.

    The lowest foot point touches the ground, whatever the noise. ``rng`` is a NumPy generator or
    :class:`slider.env.vec_env.Random`.
    """
    nominal = asarray(nominal_qpos(robot), like)
    qpos = namespace(like).tile(nominal, (count, 1))
    qvel = zeros((count, 6 + NUM_JOINTS), like)
    perturb(qpos, qvel, robot, noise, rng)
    qpos[:, 2] = _standing_heights(robot, qpos)
    return qpos, qvel


def sample_about(
    states: tuple[Array, Array], robot: RobotConfig, noise: StartNoise, rng: Any
) -> tuple[Array, Array]:
    """Positions (n, 19) and velocities (n, 18) about ``states`` of a gait.

    Robots keep the gait's height unless a foot would penetrate the ground; then they are lifted.
    """
    qpos, qvel = 1.0 * states[0], 1.0 * states[1]
    perturb(qpos, qvel, robot, noise, rng)
    qpos[:, 2] = namespace(qpos).maximum(qpos[:, 2], _standing_heights(robot, qpos))
    return qpos, qvel


def _standing_heights(robot: RobotConfig, qpos: Array) -> Array:
    """Base heights (n,) [m] at which the lowest foot point touches the ground."""
    rotation = rotation_from_quaternion(qpos[:, 3:7])
    return standing_height(robot.geometry, rotation, qpos[:, 7:])


def perturb(qpos: Array, qvel: Array, robot: RobotConfig, noise: StartNoise, rng: Any) -> None:
    """Add noise in place; joints stay within their limits."""
    count = len(qpos)
    tilt = noise.tilt * rng.standard_normal((count, 2))
    qpos[:, 3:7] = multiply_quaternions(qpos[:, 3:7], quaternion_from_tilt(tilt[:, 0], tilt[:, 1]))
    spread = np.where(SLIDES, noise.slide_position, noise.joint_position)
    qpos[:, 7:] += asarray(spread, qpos) * rng.standard_normal((count, NUM_JOINTS))
    lower, upper = (asarray(limit, qpos) for limit in robot.joint_ranges)
    qpos[:, 7:] = qpos[:, 7:].clip(lower, upper)
    qvel[:, :3] += noise.linear_velocity * rng.standard_normal((count, 3))
    qvel[:, 3:6] += noise.angular_velocity * rng.standard_normal((count, 3))
    slides = SLIDES & (robot.geometry.knee is None)
    share = asarray(np.where(slides, 0.2, 1.0), qpos)  # a slide's m/s weigh more than rad/s
    qvel[:, 6:] += noise.joint_velocity * share * rng.standard_normal((count, NUM_JOINTS))


def multiply_quaternions(a: Array, b: Array) -> Array:
    """Products (N, 4) of quaternions (N, 4) as w, x, y, z."""
    xp, w, v = namespace(a), a[:, :1], a[:, 1:]
    scalar = w[:, 0] * b[:, 0] - (v * b[:, 1:]).sum(axis=1)
    vector = w * b[:, 1:] + b[:, :1] * v + xp.linalg.cross(v, b[:, 1:])
    return xp.concat([scalar[:, None], vector], axis=1)


def rotate(quaternion: Array, angles: Array) -> Array:
    """Orientations (N, 4) turned by small angles (N, 3) [rad] about the body's own axes."""
    xp = namespace(angles)
    small = xp.concat([xp.ones_like(angles[:, :1]), 0.5 * angles], axis=1)
    small /= xp.linalg.vector_norm(small, axis=1, keepdims=True)
    return multiply_quaternions(quaternion, small)
