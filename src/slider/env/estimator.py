"""Onboard state estimate: velocity and height of the base from legs and inertial unit.

The inertial unit gives orientation, angular velocity and the velocity increment of its strapdown
integration; encoders give joint positions and velocities; motor currents give torques. A Kalman
filter with one variance for the three components predicts the base's velocity from the increment
and corrects it by leg odometry: the point of a loaded foot that touches the ground rests. After
Bloesch et al., "State estimation for legged robots: consistent fusion of leg kinematics and IMU"
(RSS 2012), with the orientation left to the inertial unit.
"""

from typing import NamedTuple

from slider.config.env import EstimatorConfig
from slider.config.robot import RobotConfig
from slider.core.arrays import Array, asarray, namespace, zeros
from slider.robot.kinematics import foot_motion
from slider.robot.names import GRAVITY, JOINTS
from slider.robot.transmission import Transmission, leg_inertia

_SLIDES = [index for index, name in enumerate(JOINTS) if name.endswith("slide")]
_END_SCALE = 0.002  # heel and toe whose heights differ by much less share the contact [m]


class Measurement(NamedTuple):
    """Sensor readings of N robots, once per update.

    Attributes:
        rotation: base to world (N, 3, 3), by the inertial unit.
        angular_velocity: (N, 3) [rad/s], base frame.
        increment: integral of the specific force since the last update (N, 3) [m/s], base frame.
        joint_positions, joint_velocities: (N, 12) [rad or m], [rad/s or m/s].
        motor_torques: mean since the last update (N, 10) [N m].
    """

    rotation: Array
    angular_velocity: Array
    increment: Array
    joint_positions: Array
    joint_velocities: Array
    motor_torques: Array


class Estimate(NamedTuple):
    """Estimated motion of N robots.

    Attributes:
        velocity: of the base origin (N, 3) [m/s], world axes.
        height: of the base origin above the loaded feet (N,) [m].
        foot_forces: vertical force of each leg by its motor torques (N, 2) [N].
    """

    velocity: Array
    height: Array
    foot_forces: Array


class StateEstimator:
    """Kalman filter of N robots; arrays are those of ``like``.

    Args:
        config: standard deviations and force thresholds.
        robot: nominal geometry, transmission and mass.
        count: number of robots N.
        like: an array of the library, precision and device to compute with.
    """

    def __init__(
        self, config: EstimatorConfig, robot: RobotConfig, count: int, like: Array
    ) -> None:
        self._config, self._geometry = config, robot.geometry
        self._slide_efforts = asarray(Transmission.of(robot).matrix[:, _SLIDES], like)
        links, slide = robot.links, robot.joints["slide"]
        self._weight = robot.mass * GRAVITY
        self._shank = links.tube.mass + links.foot.mass + links.upper_foot.mass
        self._reflected = float(leg_inertia(robot)[3, 3])
        self._damping = slide.damping
        self._state = zeros((count, 4), like)  # velocity in world axes [m/s], height [m]
        self._variance = zeros((count, 2), like)  # of a velocity component, of the height
        self._rates = zeros((count, 2), like)  # of the slides at the last update [m/s]
        self._fresh = zeros(count, like) == 0

    def reset(self, index: Array) -> None:
        """Forget the past of robots ``index``: the next update is by the lower foot alone."""
        self._fresh[index] = True

    def update(self, measured: Measurement, period: float) -> Estimate:
        """Estimate from the sensors, ``period`` [s] after the last update."""
        xp, config, rotation = namespace(measured.rotation), self._config, measured.rotation
        turning = xp.einsum("nij,nj->ni", rotation, measured.angular_velocity)
        joints, rates = measured.joint_positions, measured.joint_velocities
        feet = foot_motion(self._geometry, rotation, turning, joints, rates)
        forces = self._foot_forces(measured, feet.axes, period)
        odometry = self._odometry(feet.positions, feet.velocities)  # (N, 2, 4)

        predicted = 1.0 * self._state
        predicted[:, :3] += xp.einsum("nij,nj->ni", rotation, measured.increment)
        predicted[:, 2] -= GRAVITY * period
        predicted[:, 3] += predicted[:, 2] * period
        process = asarray([config.acceleration, config.vertical_velocity], rotation) * period
        variance = self._variance + process**2
        # A foot whose certainty is c has the variance of leg odometry over c².
        certainty = self._certainty(forces, odometry[..., 3])
        slip = odometry[..., :3] - predicted[:, None, :3]
        information = certainty**2 / (1.0 + (slip**2).sum(-1) / config.slip**2)
        total = information.sum(1)
        share = information / total.clip(1e-12, None)[:, None]
        noise = asarray([config.leg_velocity, config.leg_height], rotation) ** 2
        gain = variance * total[:, None] / (variance * total[:, None] + noise)
        gain = xp.where(self._fresh[:, None], 1.0, gain)
        innovation = (share[..., None] * odometry).sum(1) - predicted
        self._state = predicted + xp.concat([gain[:, :1]] * 3 + [gain[:, 1:]], axis=1) * innovation
        self._variance = (1.0 - gain) * variance + xp.where(self._fresh[:, None], noise, 0.0)
        self._fresh = self._fresh & False
        return Estimate(self._state[:, :3], self._state[:, 3], forces)

    def _foot_forces(self, measured: Measurement, axes: Array, period: float) -> Array:
        """Vertical ground reactions (N, 2) [N]: momentum of tube and rotors along each slide."""
        rates = measured.joint_velocities[:, _SLIDES]
        change = (rates - self._rates) / max(period, 1e-9)
        specific = namespace(axes).einsum(
            "nij,nj,nli->nl", measured.rotation, measured.increment / max(period, 1e-9), axes
        )
        force = measured.motor_torques @ self._slide_efforts
        force = force - 0.5 * self._damping * (rates + self._rates)
        force = force + self._shank * specific - (self._reflected + self._shank) * change
        self._rates = rates
        return force * axes[..., 2]

    def _certainty(self, forces: Array, heights: Array) -> Array:
        """How certainly a foot stands (N, 2) in [0, 1]: by its force, at first by its height."""
        xp, (low, high) = namespace(forces), (self._config.lifted, self._config.loaded)
        loaded = ((forces / self._weight - low) / (high - low)).clip(0.0, 1.0)
        lower = heights >= xp.amax(heights, 1)[:, None]
        return xp.where(self._fresh[:, None], 1.0 * lower, loaded)

    def _odometry(self, positions: Array, velocities: Array) -> Array:
        """Velocity and height of the base (N, 2, 4) if a foot rests at the end that is lower."""
        xp, heights = namespace(positions), positions[..., 2]
        toe = 1.0 / (1.0 + xp.exp((heights[..., 1] - heights[..., 0]) / _END_SCALE))
        ends = xp.stack([1.0 - toe, toe], axis=-1)
        velocity = -(ends[..., None] * velocities).sum(2)
        return xp.concat([velocity, -(ends * heights).sum(2)[..., None]], axis=-1)
