"""From positions, velocities and sensors of the simulation to named quantities."""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

from collections.abc import Sequence
from typing import Any

import mujoco

from slider.core.arrays import namespace
from slider.env.state import RobotState
from slider.robot import names
from slider.robot.kinematics import rotation_from_quaternion, turn_to_heading, yaw_of

SPEED_LIMIT = 1000.0  # [rad/s, m/s]; beyond it a state counts as blown up


def columns_of(model: mujoco.MjModel, sensor: str) -> Sequence[int]:
    """Columns of a sensor in the sensor array."""
    start = int(model.sensor(sensor).adr[0])
    return range(start, start + int(model.sensor(sensor).dim[0]))


class SensorIndex:
    """Columns of the sensor array that :func:`read` needs."""

    def __init__(self, model: mujoco.MjModel) -> None:
        def of(sensor: str) -> Sequence[int]:
            return columns_of(model, sensor)

        sides = names.SIDES
        self.torques = [of(f"{motor}_torque")[0] for motor in names.MOTORS]
        self.soles = [c for side in sides for c in of(f"{side}_sole_position")]
        self.sole_velocities = [c for side in sides for c in of(f"{side}_sole_velocity")]
        self.forces = [of(f"{side}_foot_force")[2] for side in sides]  # z of the net force
        bodies = (names.BASE, *(names.tube(side) for side in sides))
        self.contacts = [of(f"{body}_contact")[0] for body in bodies]


def read(
    qpos: Any,
    qvel: Any,
    sensors: Any,
    index: SensorIndex,
    diverged: Any,
) -> RobotState:
    """Name the quantities of N robots, as copies: arrays of arrays, tensors of tensors.

    Args:
        qpos: (N, 19), and velocities ``qvel`` (N, 18).
        sensors: (N, sensors).
        index: of the sensors.
        diverged: (N,) robots whose simulation blew up.
    """
    qpos, qvel = 1.0 * qpos, 1.0 * qvel
    rotation = rotation_from_quaternion(qpos[:, 3:7])
    yaw = yaw_of(rotation)
    return RobotState(
        base_position=qpos[:, :3],
        quaternion=qpos[:, 3:7],
        rotation=rotation,
        yaw=yaw,
        linear_velocity=namespace(qvel).einsum("nij,ni->nj", rotation, qvel[:, :3]),
        angular_velocity=qvel[:, 3:6],
        heading_velocity=turn_to_heading(qvel, yaw),
        gravity=-rotation[:, 2, :],
        joint_positions=qpos[:, 7:],
        joint_velocities=qvel[:, 6:],
        motor_torques=sensors[:, index.torques],
        foot_positions=sensors[:, index.soles].reshape(-1, 2, 3),
        foot_velocities=sensors[:, index.sole_velocities].reshape(-1, 2, 3),
        foot_forces=abs(sensors[:, index.forces]),
        body_contacts=sensors[:, index.contacts].sum(axis=1),
        diverged=diverged | False,
    )
