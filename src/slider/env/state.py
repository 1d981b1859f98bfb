"""Named quantities of many robots, read from the physics once per control step."""

from dataclasses import dataclass

from slider.core.arrays import Array, namespace
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

    base_position: Array
    quaternion: Array
    rotation: Array
    yaw: Array
    linear_velocity: Array
    angular_velocity: Array
    heading_velocity: Array
    gravity: Array
    joint_positions: Array
    joint_velocities: Array
    motor_torques: Array
    foot_positions: Array
    foot_velocities: Array
    foot_forces: Array
    body_contacts: Array
    diverged: Array
    ground: Ground = FLAT

    @property
    def num_robots(self) -> int:
        """Number of robots N."""
        return len(self.yaw)

    @property
    def base_height(self) -> Array:
        """Height of the base above the ground below it (N,) [m]."""
        return self.base_position[:, 2] - self.ground.height(self.base_position[:, :2])

    @property
    def qpos(self) -> Array:
        """MuJoCo's generalised positions (N, 19)."""
        parts = [self.base_position, self.quaternion, self.joint_positions]
        return namespace(*parts).concat(parts, axis=1)

    @property
    def qvel(self) -> Array:
        """MuJoCo's generalised velocities (N, 18): linear world, angular base frame."""
        xp = namespace(self.rotation)
        linear = xp.einsum("nij,nj->ni", self.rotation, self.linear_velocity)
        return xp.concat([linear, self.angular_velocity, self.joint_velocities], axis=1)
