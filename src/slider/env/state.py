"""Named quantities of many robots, and what observation and reward terms read besides them."""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from slider.config.env import HeightScan
from slider.core.arrays import Array, namespace, tensors
from slider.env.height_field import FLAT, Ground, ScannedGround
from slider.env.phase import gait_velocity_of
from slider.robot import names
from slider.robot.kinematics import rotation_from_quaternion, turn_to_heading, yaw_of

if TYPE_CHECKING:  # config checks import this module: keep that fast
    import mujoco

SPEED_LIMIT = 1000.0  # [rad/s, m/s]; beyond it a state counts as blown up


@dataclass(frozen=True)
class RobotState:
    """State of N robots. World frame: x, y horizontal, z up; heading frame: turned by the yaw.

    Torques, feet and contacts come from sensors, which MuJoCo evaluates before it integrates: they
    are one simulation step older than the rest.

    Attributes:
        base_position: (N, 3) [m], world.
        quaternion: (N, 4), base to world, as w, x, y, z.
        rotation: (N, 3, 3), base to world.
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
        ground: under the robots.
        scanned: the ground as the height scan measures it; none: exactly.
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
    scanned: ScannedGround | None = None

    def tensors(self, like: Array) -> "RobotState":
        """Convert to tensors on the device and in the precision of ``like``.

        On the CPU, in double precision, they share the memory of the arrays.
        """
        return tensors(self, like)

    @property
    def num_robots(self) -> int:
        """Number of robots N."""
        return len(self.yaw)

    @property
    def base_height(self) -> Array:
        """Height of the base above the mean of the ground under the feet (N,) [m]."""
        under = self.ground.height(self.foot_positions[..., :2], gaps=False)
        return self.base_position[:, 2] - under.mean(-1)

    @property
    def qpos(self) -> Array:
        """MuJoCo's generalised positions (N, 19)."""
        parts = [self.base_position, self.quaternion, self.joint_positions]
        return namespace(parts[0]).concat(parts, axis=1)

    @property
    def qvel(self) -> Array:
        """MuJoCo's generalised velocities (N, 18): linear world, angular base frame."""
        xp = namespace(self.rotation)
        linear = xp.einsum("nij,nj->ni", self.rotation, self.linear_velocity)
        return xp.concat([linear, self.angular_velocity, self.joint_velocities], axis=1)


class SensorIndex:
    """Columns of the sensor array; those of ``instruments`` only where the model has them."""

    def __init__(self, model: "mujoco.MjModel", instruments: bool = False) -> None:
        def of(sensor: str) -> range:
            start = int(model.sensor(sensor).adr[0])
            return range(start, start + int(model.sensor(sensor).dim[0]))

        sides = names.SIDES
        self.torques = [of(f"{model.actuator(k).name}_torque")[0] for k in range(model.nu)]
        self.soles = [c for side in sides for c in of(f"{side}_sole_position")]
        self.sole_velocities = [c for side in sides for c in of(f"{side}_sole_velocity")]
        self.forces = [of(f"{side}_foot_force")[2] for side in sides]  # z of the net force
        bodies = (names.BASE, *(names.tube(side) for side in sides))
        self.contacts = [of(f"{body}_contact")[0] for body in bodies]
        if instruments:
            ends = [[f"{side}_{end}" for end in names.FOOT_ENDS] for side in sides]
            self.ends = [[of(f"{end}_position") for end in foot] for foot in ends]
            self.end_velocities = [[of(f"{end}_velocity") for end in foot] for foot in ends]
            self.turning = [of(f"{side}_foot_turning") for side in sides]
            self.distances = [of(f"{a}_{b}_distance")[0] for a, b in names.LEG_PAIRS]


def read_state(qpos: Any, qvel: Any, sensors: Any, index: SensorIndex, diverged: Any) -> RobotState:
    """Name the quantities of N robots, as copies; arrays stay arrays, tensors stay tensors.

    Arguments: ``qpos`` (N, 19), ``qvel`` (N, 18), ``sensors`` (N, sensors), ``diverged`` (N,).
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


@dataclass(frozen=True)
class View:
    """State of N robots together with the commands and actions of their agent.

    Attributes:
        state: the robots.
        command: (N, 4) vx, vy [m/s], yaw rate [rad/s], heading error [rad].
        action, previous_action: (N, 12) unscaled, unmirrored.
        action_scale: (12,) joint motion of an action of 1 [rad or m].
        filtered_velocity: (N, 2) low-pass filtered forward and leftward velocity [m/s].
        reference_velocity: (N, 2) rate-limited commanded velocity [m/s].
        expected_velocity: (N, 2) reference_velocity, filtered like filtered_velocity [m/s].
        phase: (N,) clock in [0, 1); zero without a clock.
        halted: (N,) whether the clock is halted at a change of stance foot: the robot stands.
        nominal: (12,) joint positions of the nominal pose [rad or m].
        nominal_height: base height of the nominal pose [m].
        torque_limits: (10,) of the motors [N m].
        period: control period [s].
        scan: grid of the height scan.
    """

    state: RobotState
    command: Array
    action: Array
    previous_action: Array
    action_scale: Array
    filtered_velocity: Array
    reference_velocity: Array
    expected_velocity: Array
    phase: Array
    halted: Array
    nominal: Array
    nominal_height: float
    torque_limits: Array
    period: float
    scan: HeightScan

    @property
    def gait_velocity(self) -> Array:
        """Command (N, 3) of the gait in use: reference velocity, commanded yaw rate."""
        return gait_velocity_of(self.reference_velocity, self.command)
