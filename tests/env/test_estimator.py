"""The onboard estimate against the true state, of robots that sway, step, slip and fall freely."""

import numpy as np
import pytest

from slider.config.env import EstimatorConfig
from slider.env.estimator import Estimate, Measurement, StateEstimator
from slider.env.physics import BatchedPhysics
from slider.robot.names import GRAVITY, JOINTS, NUM_JOINTS
from tests.env.synthetic import make_physics, robot_config, stand

CONFIG = EstimatorConfig(
    acceleration=0.5,
    vertical_velocity=0.05,
    leg_velocity=0.1,
    leg_height=0.005,
    slip=0.4,
    lifted=0.25,
    loaded=0.5,
)


class Sensors:
    """Perfect sensors of robots in physics."""

    def __init__(self, physics: BatchedPhysics) -> None:
        self.physics = physics
        self.velocity = physics.qvel[:, :3].copy()

    def read(self, torques: np.ndarray, period: float) -> Measurement:
        state = self.physics.read()
        change = self.physics.qvel[:, :3] - self.velocity + [0.0, 0.0, GRAVITY * period]
        self.velocity = self.physics.qvel[:, :3].copy()
        return Measurement(
            rotation=state.rotation,
            angular_velocity=state.angular_velocity,
            increment=np.einsum("nji,nj->ni", state.rotation, change),
            joint_positions=state.joint_positions,
            joint_velocities=state.joint_velocities,
            motor_torques=torques,
        )


def joint(name: str) -> list[int]:
    return [JOINTS.index(f"{side}_{name}") for side in ("left", "right")]
