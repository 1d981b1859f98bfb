"""Wanted accelerations of the parts of the body, as tasks of the whole-body QP."""

import numpy as np

from slider.config.control import TaskConfig, WholeBodyConfig
from slider.control.mpc.nominal import NUM_DOFS, Dynamics
from slider.control.mpc.whole_body import Tasks
from slider.robot.kinematics import about_z, yaw_of

Part = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Jacobian (n, r, 18), wanted acceleration less the bias (n, r), weight (r,)."""


class Motion:
    """Builds tasks for n robots from their dynamics and references."""

    def __init__(self, config: WholeBodyConfig) -> None:
        self._config = config

    def com(self, dynamics: Dynamics, acceleration: np.ndarray, weight: np.ndarray) -> Part:
        """Centre of mass with a wanted acceleration (n, 3) [m/s²]."""
        return dynamics.com_jacobian, acceleration - dynamics.com_bias, weight

    def base(self, dynamics: Dynamics, heading: np.ndarray, yaw_rate: np.ndarray) -> Part:
        """Base upright, looking along ``heading`` (n,) [rad] that turns with ``yaw_rate`` (n,)."""
        n, rotation = len(heading), dynamics.base_rotation
        rate = -(rotation @ dynamics.qvel[:, 3:6, None])[..., 0]
        rate[:, 2] += yaw_rate
        jacobian = np.zeros((n, 3, NUM_DOFS))
        jacobian[:, :, 3:6] = rotation  # base rates are in its own frame
        error = _rotation_error(about_z(heading), rotation)
        return jacobian, *_wanted(self._config.base, error, rate)

    def swing(self, dynamics: Dynamics, foot: np.ndarray, reference: np.ndarray) -> Part:
        """Swing foot (n,) follows ``reference`` (n, 3, 3): axis; place, velocity, acceleration."""
        robots = np.arange(len(foot))
        jacobian = dynamics.foot_jacobians[robots, foot, :3]
        error = reference[:, :, 0] - dynamics.foot_positions[robots, foot]
        rate = reference[:, :, 1] - _velocity(jacobian, dynamics.qvel)
        wanted, weight = _wanted(self._config.swing, error, rate)
        bias = dynamics.foot_bias[robots, foot, :3]
        return jacobian, wanted + reference[:, :, 2] - bias, weight

    def swing_rotation(
        self, dynamics: Dynamics, foot: np.ndarray, heading: np.ndarray, yaw_rate: np.ndarray
    ) -> Part:
        """Swing foot (n,) level, along ``heading`` (n,) [rad]; free about its line."""
        robots = np.arange(len(foot))
        rotation = dynamics.foot_rotations[robots, foot]
        axes = pitch_and_yaw(rotation)
        jacobian = axes @ dynamics.foot_jacobians[robots, foot, 3:]
        bias = (axes @ dynamics.foot_bias[robots, foot, 3:, None])[..., 0]
        error = np.stack(
            [np.arcsin(rotation[:, 2, 0]), _wrapped(heading - yaw_of(rotation))], axis=1
        )
        rate = -_velocity(jacobian, dynamics.qvel)
        rate[:, 1] += yaw_rate
        wanted, weight = _wanted(self._config.swing_rotation, error, rate)
        return jacobian, wanted - bias, weight[1:]

    def stance(self, dynamics: Dynamics, feet: np.ndarray, sinking: np.ndarray) -> Part:
        """The lines of ``feet`` (n, k) do not move; those in the air sink (n, k) [m/s]."""
        n, count = feet.shape
        robots = np.arange(n)[:, None]
        axes = np.zeros((n, count, 5, 6))
        axes[:, :, :3, :3] = np.eye(3)
        axes[:, :, 3:, 3:] = pitch_and_yaw(dynamics.foot_rotations[robots, feet])
        jacobian = (axes @ dynamics.foot_jacobians[robots, feet]).reshape(n, -1, NUM_DOFS)
        bias = (axes @ dynamics.foot_bias[robots, feet][..., None]).reshape(n, -1)
        rate = -_velocity(jacobian, dynamics.qvel).reshape(n, count, 5)
        rate[:, :, 2] -= sinking
        task = self._config.stance
        wanted = task.kd * rate.reshape(n, -1) - bias
        weight = np.tile([task.weight[0]] * 3 + [task.weight[1], task.weight[2]], count)
        return jacobian, wanted, weight


def join(parts: list[Part]) -> Tasks:
    """One set of rows from several parts."""
    jacobians, wanted, weights = zip(*parts, strict=True)
    return Tasks(np.concatenate(jacobians, 1), np.concatenate(wanted, 1), np.concatenate(weights))


def pitch_and_yaw(rotation: np.ndarray) -> np.ndarray:
    """World axes (…, 2, 3) about which a foot pitches and yaws: level and leftward, vertical."""
    along = rotation[..., :2, 0] / np.linalg.norm(rotation[..., :2, 0], axis=-1, keepdims=True)
    axes = np.zeros((*rotation.shape[:-2], 2, 3))
    axes[..., 0, 0], axes[..., 0, 1] = -along[..., 1], along[..., 0]
    axes[..., 1, 2] = 1.0
    return axes


def _wanted(task: TaskConfig, error: np.ndarray, rate: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return task.kp * error + task.kd * rate, np.array(task.weight)


def _velocity(jacobian: np.ndarray, qvel: np.ndarray) -> np.ndarray:
    return (jacobian @ qvel[:, :, None])[..., 0]


def _rotation_error(wanted: np.ndarray, found: np.ndarray) -> np.ndarray:
    """World vector (n, 3) [rad] of the turn from ``found`` to ``wanted``, small angles."""
    difference = wanted @ found.swapaxes(1, 2)
    skew = 0.5 * (difference - difference.swapaxes(1, 2))
    return np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=1)


def _wrapped(angle: np.ndarray) -> np.ndarray:
    return (angle + np.pi) % (2 * np.pi) - np.pi
