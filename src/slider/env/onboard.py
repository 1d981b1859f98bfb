"""Onboard sensors of the robots, and the state estimated from them."""

from dataclasses import fields, replace
from functools import partial

from slider.config.env import OnboardConfig, SensingConfig
from slider.config.robot import RobotConfig
from slider.core.arrays import Array, asarray, namespace, zeros
from slider.env.disturbance import (
    BIAS,
    DROP_OUT,
    NUMBERS,
    READING,
    SCAN,
    SCAN_BIAS,
    SeededRandom,
    with_noise,
)
from slider.env.estimator import StateEstimator
from slider.env.height_field import FLAT, ScannedGround
from slider.env.starts import SLIDES, rotate
from slider.env.state import RobotState
from slider.robot.kinematics import rotation_from_quaternion, turn_to_heading
from slider.robot.names import GRAVITY, NUM_JOINTS, motor_names

_READING = NUMBERS + 3  # standard normal numbers of a reading
_BIASES = 9 + NUM_JOINTS  # and one per motor


class OnboardState:
    """Sensors and estimators of N nominal robots; arrays have the type and device of ``like``.

    The robots come in blocks of the same size, one for each of the ``seeds``.
    """

    def __init__(
        self,
        config: OnboardConfig,
        robot: RobotConfig,
        seeds: tuple[int, ...],
        count: int,
        like: Array,
    ) -> None:
        self._sensors, self._like, self._count = config.sensors, like, count
        shared = {f.name: getattr(config.sensors, f.name, 0.0) for f in fields(SensingConfig)}
        self._noise = SensingConfig(**shared)
        self._estimator = StateEstimator(config.estimator, robot, count, like)
        self._draws = SeededRandom(seeds, count, like)
        self._motors = len(motor_names(robot.geometry))
        self._biased = asarray(~SLIDES | (robot.geometry.knee is not None), like)
        self.restart()

    def restart(self) -> None:
        """Restart the sequence of sensor errors."""
        self._steps, self._episodes = 0, 0
        self._elapsed, self._age, self._scan_bias = zeros((3, self._count), self._like)
        self._velocity = zeros((self._count, 3), self._like)
        self._torques = zeros((self._count, self._motors), self._like)
        self._bias = zeros((self._count, _BIASES + self._motors), self._like)

    def begin(self, index: Array, qpos: Array, qvel: Array) -> None:
        """Start robots ``index`` at positions (n, 19) and velocities (n, 18) with new biases."""
        self._bias[index] = self._draws.normal(BIAS, self._episodes, _BIASES + self._motors)[index]
        self._scan_bias[index] = self._draws.normal(SCAN_BIAS, self._episodes, 1)[index, 0]
        self._episodes += 1
        self._velocity[index] = qvel[:, :3]
        self._elapsed[index] = self._age[index] = self._torques[index] = 0.0
        self._estimator.reset(index, qpos[:, :2])

    def advance(self, period: float, steps: int, torques: Array) -> None:
        """Advance by ``period`` [s], ``steps`` simulation steps, with mean torques (N, m) [N m]."""
        self._torques = torques
        self._elapsed += period
        self._age += period
        self._steps += steps

    def measure(self, state: RobotState) -> RobotState:
        """Estimate the state from the true one, as on flat ground at the height of the feet."""
        xp, sensors, elapsed = namespace(self._age), self._sensors, self._elapsed[:, None]
        normal = self._draws.normal(READING, self._steps, _READING)
        gyro, acceleration, tilt = (self._bias[:, k : k + 3] for k in (0, 3, 6))
        joint, motor = self._bias[:, 9 : 9 + NUM_JOINTS], self._bias[:, 9 + NUM_JOINTS :]

        velocity = state.qvel[:, :3]
        change = velocity - self._velocity
        change[:, 2] += GRAVITY * self._elapsed
        increment = xp.einsum("nji,nj->ni", state.rotation, change)
        increment = increment + sensors.acceleration_bias * acceleration * elapsed
        increment = increment + sensors.velocity_increment * elapsed**0.5 * normal[:, -3:]
        scale = asarray([sensors.tilt_bias, sensors.tilt_bias, sensors.heading_drift], normal)
        angles = scale * tilt
        angles[:, 2] *= self._age
        quaternion = rotate(state.quaternion, angles)
        rotation = rotation_from_quaternion(quaternion)
        offset = sensors.joint_bias * self._biased * joint
        biased = replace(
            state,
            quaternion=quaternion,
            rotation=rotation,
            angular_velocity=state.angular_velocity + sensors.angular_velocity_bias * gyro,
            joint_positions=state.joint_positions + offset,
            motor_torques=self._torques * (1.0 + sensors.torque * motor),
        )
        read = with_noise(biased, self._noise, normal[:, :-3])
        estimate = self._estimator.update(read, increment, self._elapsed)
        self._velocity = velocity
        self._elapsed = 0.0 * self._elapsed
        position, feet = estimate.position, estimate.feet
        return replace(
            read,
            base_position=position,
            linear_velocity=xp.einsum("nji,nj->ni", read.rotation, estimate.velocity),
            heading_velocity=turn_to_heading(estimate.velocity, read.yaw),
            foot_positions=position[:, None] + 0.5 * feet.positions.sum(2),
            foot_velocities=estimate.velocity[:, None] + 0.5 * feet.velocities.sum(2),
            foot_forces=estimate.foot_forces,
            body_contacts=0 * state.body_contacts,
            ground=FLAT,
            scanned=self._scanned(state, position, read.yaw),
        )

    def _scanned(self, state: RobotState, position: Array, yaw: Array) -> ScannedGround:
        """Ground around the true ``state``, read at estimated positions (N, 3) and yaws (N,)."""
        sensors, late = self._sensors, self._sensors.scan_delay * state.qvel[:, :2]
        return ScannedGround(
            state.ground,
            centre=position[:, :2],
            place=state.base_position[:, :2] - late,
            turn=state.yaw - yaw,
            lift=position[:, 2] - state.base_position[:, 2] + sensors.scan_bias * self._scan_bias,
            level=0.0 * position[:, 2],
            noise=sensors.scan,
            drop_out=sensors.scan_drop_out,
            normal=partial(self._draws.normal, SCAN, self._steps),
            uniform=partial(self._draws.uniform, DROP_OUT, self._steps),
        )
