"""Torques on one foot: a pendulum that falls freely over it, and a swing foot on its way."""

import numpy as np

from slider.config.control import MpcConfig, SteppingBodyConfig
from slider.control.whole_body import lip
from slider.control.whole_body.memory import Memory
from slider.control.whole_body.nominal import Dynamics
from slider.control.whole_body.tasks import (
    BodyControl,
    Part,
    Solved,
    feedback,
    pitch_and_yaw,
    point_velocity,
    wrapped,
)
from slider.robot.kinematics import yaw_of


class SingleSupport:
    """Torques of n robots on one foot.

    Args:
        config: settings of the baseline.
        body: tasks of the body and their solution.
        height: of the pendulum [m].
    """

    def __init__(self, config: MpcConfig, body: BodyControl, height: float) -> None:
        self._config, self._body = config, body
        self._omega = lip.rate(height)
        self._swing = SwingTasks(config.whole_body)

    def torques(self, memory: Memory, robots: np.ndarray, dynamics: Dynamics) -> Solved:
        """The pendulum falls freely over the stance foot; the other one follows its reference."""
        config, stance = self._config, memory.stance[robots]
        support = dynamics.foot_positions[np.arange(len(robots)), stance]
        flat = self._omega**2 * (dynamics.com - support)[:, :2]
        weight = np.array(config.whole_body.com.weight)
        foot, yaw_rate = 1 - stance, memory.yaw_rate(robots)
        heading = memory.heading[robots] + 0.5 * yaw_rate * config.step.time
        feet = stance[:, None]
        parts = [
            *self._body.body(memory, robots, dynamics, flat, support[:, 2], weight),
            self._swing.swing(dynamics, foot, memory.swing[robots]),
            self._swing.swing_rotation(dynamics, foot, heading, yaw_rate),
            self._body.tasks.stance(dynamics, feet, np.zeros(feet.shape)),
        ]
        return self._body.solve(dynamics, parts, feet, np.ones(feet.shape, dtype=bool))


class SwingTasks:
    """Builds tasks of the swing foot for n robots."""

    def __init__(self, config: SteppingBodyConfig) -> None:
        self._config = config

    def swing(self, dynamics: Dynamics, foot: np.ndarray, reference: np.ndarray) -> Part:
        """Swing foot (n,) follows ``reference`` (n, 3, 3): axis; place, velocity, acceleration."""
        robots = np.arange(len(foot))
        jacobian = dynamics.foot_jacobians[robots, foot, :3]
        error = reference[:, :, 0] - dynamics.foot_positions[robots, foot]
        rate = reference[:, :, 1] - point_velocity(jacobian, dynamics.qvel)
        desired, weight = feedback(self._config.swing, error, rate)
        bias = dynamics.foot_bias[robots, foot, :3]
        return jacobian, desired + reference[:, :, 2] - bias, weight

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
            [np.arcsin(rotation[:, 2, 0]), wrapped(heading - yaw_of(rotation))], axis=1
        )
        rate = -point_velocity(jacobian, dynamics.qvel)
        rate[:, 1] += yaw_rate
        desired, weight = feedback(self._config.swing_rotation, error, rate)
        return jacobian, desired - bias, weight[1:]
