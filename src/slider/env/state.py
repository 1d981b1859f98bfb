"""Named quantities of many robots, read from the physics once per control step."""

from dataclasses import dataclass

import numpy as np

from slider.env.ground import FLAT, Ground


@dataclass(frozen=True)
class RobotState:
    """State of N robots. World frame: x, y horizontal, z up; heading frame: turned by the yaw.

    Torques, feet and contacts come from sensors, which MuJoCo evaluates before it integrates: they
    are one simulation step older than the rest.

    Attributes:
        base_position: (N, 3) [m], world.
        quaternion: (N, 4), base to world, as w, x, y, z.
        rotation: (N, 3, 3), the same.
        yaw: (N,) [rad].
        linear_velocity: (N, 3) [m/s], base frame.
        angular_velocity: (N, 3) [rad/s], base frame.
        heading_velocity: (N, 2) forward and leftward velocity of the base [m/s], heading frame.
        gravity: (N, 3), direction of gravity in the base frame.
        joint_positions, joint_velocities: (N, 12) [rad or m], [rad/s or m/s].
        motor_torques: (N, 10) [N m].
        foot_positions: (N, 2, 3) middle of the foot lines [m], world.
        foot_velocities: (N, 2, 3) of the same points [m/s], world.
        foot_forces: (N, 2) vertical ground reaction [N].
        body_contacts: (N,) number of contacts of other bodies with the ground.
        diverged: (N,) the simulation of this robot blew up in the last control step.
        ground: on which the robots are.
    """

    base_position: np.ndarray
    quaternion: np.ndarray
    rotation: np.ndarray
    yaw: np.ndarray
    linear_velocity: np.ndarray
    angular_velocity: np.ndarray
    heading_velocity: np.ndarray
    gravity: np.ndarray
    joint_positions: np.ndarray
    joint_velocities: np.ndarray
    motor_torques: np.ndarray
    foot_positions: np.ndarray
    foot_velocities: np.ndarray
    foot_forces: np.ndarray
    body_contacts: np.ndarray
    diverged: np.ndarray
    ground: Ground = FLAT

    @property
    def num_robots(self) -> int:
        """Number of robots N."""
        return len(self.yaw)

    @property
    def base_height(self) -> np.ndarray:
        """Height of the base above the ground below it (N,) [m]."""
        return self.base_position[:, 2] - self.ground.height(self.base_position[:, :2])

    @property
    def qpos(self) -> np.ndarray:
        """MuJoCo's generalised positions (N, 19)."""
        return np.concatenate([self.base_position, self.quaternion, self.joint_positions], axis=1)

    @property
    def qvel(self) -> np.ndarray:
        """MuJoCo's generalised velocities (N, 18): linear world, angular base frame."""
        linear = np.einsum("nij,nj->ni", self.rotation, self.linear_velocity)
        return np.concatenate([linear, self.angular_velocity, self.joint_velocities], axis=1)
