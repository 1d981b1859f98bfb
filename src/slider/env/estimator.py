"""Onboard state estimate: position and velocity of the base from leg odometry and the IMU.

The IMU measures orientation, angular velocity and the velocity increment of its strapdown
integration; encoders measure joint positions and velocities; motor currents give torques. A Kalman
filter with one variance for the three components predicts the base's velocity from the increment
and corrects it, and the increment's bias, by leg odometry: the contact point of a loaded foot is
at rest. After Bloesch et al., "State estimation for legged robots: consistent fusion of leg
kinematics and IMU" (RSS 2012), with the orientation left to the IMU. A momentum observer along the
leg (De Luca et al., IROS 2006) estimates the force of a foot: from the force of the slide, or from
that of the joints along the leg's length (virtual work).
"""

from typing import NamedTuple

import numpy as np

from slider.config.env import EstimatorConfig
from slider.config.robot import RobotConfig
from slider.core.arrays import Array, asarray, namespace, zeros
from slider.env.starts import SLIDES
from slider.env.state import RobotState
from slider.robot.bodies import own_bodies, total_mass
from slider.robot.kinematics import FootMotion, foot_motion, leg_extension_jacobian
from slider.robot.names import GRAVITY, LEG_GAIT_JOINTS, LEG_SIZE, NUM_JOINTS, SIDES
from slider.robot.transmission import Transmission, leg_inertia

_END_SCALE = 0.002  # heel and toe whose heights differ by much less share the contact [m]


class Estimate(NamedTuple):
    """Estimated motion of N robots, world axes.

    Attributes:
        velocity: of the base origin (N, 3) [m/s].
        position: of the base origin (N, 3) [m]: integrated from the start horizontally, height
            above the loaded feet.
        foot_forces: vertical ground reactions (N, 2) [N]; 0 for a foot in the air.
        feet: motion of the feet relative to the base.
    """

    velocity: Array
    position: Array
    foot_forces: Array
    feet: FootMotion


class Leg(NamedTuple):
    """Constants of a leg, for the estimate of its foot's force.

    Attributes:
        weight: of the robot [N].
        mass: of what moves with a slide, or below a knee [kg].
        moment: of this mass about the hip, with all joints at 0 [kg m].
        reflected_mass: inertia of rotors and joints reflected to the leg's length [kg].
        damping: of the leg's length [N s/m].
    """

    weight: float
    mass: float
    moment: float
    reflected_mass: float
    damping: float

    @classmethod
    def of(cls, robot: RobotConfig) -> "Leg":
        """Constants of the nominal robot."""
        bodies, geometry = own_bodies(robot), robot.geometry
        tube, below = bodies["tube"], [bodies[n] for n in ("foot", "sole") if n in bodies]
        depth = -tube.com[2] - (geometry.knee or (0.0, 0.0, 0.0))[2]
        extension = leg_extension_jacobian(geometry, np.zeros((1, NUM_JOINTS)), 0)[0]
        damping = [robot.joints[name].damping for name in geometry.leg_joints[:LEG_GAIT_JOINTS]]
        inertia = leg_inertia(robot)[:LEG_GAIT_JOINTS, :LEG_GAIT_JOINTS]
        return cls(
            weight=total_mass(bodies) * GRAVITY,
            mass=tube.mass + sum(part.mass for part in below),
            moment=tube.mass * depth
            + sum(part.mass * (geometry.leg_length - part.com[2]) for part in below),
            reflected_mass=float(extension @ inertia @ extension),
            damping=float(extension**2 @ damping),
        )


class StateEstimator:
    """Kalman filter of N nominal robots; arrays have the type and device of ``like``."""

    def __init__(
        self, config: EstimatorConfig, robot: RobotConfig, count: int, like: Array
    ) -> None:
        self._config, self._geometry = config, robot.geometry
        motors = Transmission.of(robot).matrix
        self._slide_efforts = asarray(motors[:, SLIDES], like)
        starts = (leg * LEG_SIZE for leg in range(len(SIDES)))
        self._legs = [asarray(motors[:, start : start + LEG_GAIT_JOINTS], like) for start in starts]
        self._leg = Leg.of(robot)
        self.velocity, self.position, self.bias = zeros((3, count, 3), like)
        self.variance = zeros((count, 2), like)  # of a velocity component, of the height
        self.rates, self.forces = zeros((2, count, 2), like)  # of the slides [m/s], feet [N]
        self.fresh = zeros(count, like) == 0

    def reset(self, index: Array, place: Array) -> None:
        """Start robots ``index`` at ``place`` (n, 2) [m]; the lower foot initialises the rest."""
        for values in (self.velocity, self.bias, self.variance, self.forces, self.rates):
            values[index] = 0.0
        self.fresh[index] = True
        self.position[index, :2] = place

    def update(self, measured: RobotState, increment: Array, elapsed: Array) -> Estimate:
        """Estimate from new readings.

        Args:
            measured: rotation and angular velocity by the inertial unit, joint positions and
                velocities, mean motor torques since the last readings.
            increment: integral of the specific force since then (N, 3) [m/s], in the base frame at
                the time of the reading.
            elapsed: time since then (N,) [s]; where it is zero, and the robot has not been reset,
                the estimate stays.
        """
        xp, rotation, config = namespace(elapsed), measured.rotation, self._config
        turning = xp.einsum("nij,nj->ni", rotation, measured.angular_velocity)
        joints, rates = measured.joint_positions, measured.joint_velocities
        feet = foot_motion(self._geometry, rotation, turning, joints, rates)
        gained = increment - self.bias * elapsed[:, None]
        velocity = self.velocity + xp.einsum("nij,nj->ni", rotation, gained)
        velocity[:, 2] -= GRAVITY * elapsed
        position = self.position + velocity * elapsed[:, None]
        deviations = asarray([config.acceleration, config.vertical_velocity], elapsed)
        variance = self.variance + (deviations * elapsed[:, None]) ** 2

        leg_velocities, leg_heights = _odometry(feet)
        along = self._pushed(measured), feet.growing, feet.excess
        specific = xp.einsum("nij,nj,nli->nl", rotation, increment, feet.axes)
        forces = self._foot_forces(specific, feet, elapsed, along)
        slip = ((leg_velocities - velocity[:, None]) ** 2).sum(-1) / config.slip**2
        # A foot of certainty c has the variance of leg odometry divided by c².
        # The certainty follows from the foot's force, after a reset from its height.
        low, high = config.lifted, config.loaded
        loaded = ((forces / self._leg.weight - low) / (high - low)).clip(0.0, 1.0)
        lower = leg_heights >= xp.amax(leg_heights, 1)[:, None]
        certainty = xp.where(self.fresh[:, None], 1.0 * lower, loaded)
        information = certainty**2 / (1.0 + slip)
        total = information.sum(1)
        share = information / total.clip(1e-12, None)[:, None]
        noise = asarray([config.leg_velocity, config.leg_height], elapsed) ** 2
        gain = variance * total[:, None] / (variance * total[:, None] + noise)
        fresh = self.fresh[:, None]
        gain = xp.where(fresh, 1.0, gain)
        correction = gain[:, :1] * ((share[..., None] * leg_velocities).sum(1) - velocity)
        velocity += correction
        # The steady gain of a Kalman filter whose bias is a random walk.
        bias = self.bias - xp.einsum("nji,nj->ni", rotation, correction) / config.bias_time
        position[:, 2] += gain[:, 1] * ((share * leg_heights).sum(1) - position[:, 2])

        due = fresh | (elapsed > 0)[:, None]
        self.velocity = xp.where(due, velocity, self.velocity)
        self.position = xp.where(due, position, self.position)
        self.bias = xp.where(due & ~fresh, bias, self.bias)
        self.variance = xp.where(due, (1 - gain) * variance + fresh * noise, self.variance)
        self.rates = xp.where(due, along[1], self.rates)
        self.forces = xp.where(due, forces, self.forces)
        self.fresh = self.fresh & False
        lifted = config.lifted * self._leg.weight
        carried = xp.where(self.forces > lifted, self.forces, 0.0)
        return Estimate(self.velocity, self.position, carried, feet)

    def _foot_forces(
        self, specific: Array, feet: FootMotion, elapsed: Array, along: tuple[Array, Array, Array]
    ) -> Array:
        """Vertical ground reactions (N, 2) [N] from the momentum of tube and rotors along each leg.

        ``specific`` (N, 2) [m/s] are the increments along the legs. The angular acceleration of
        the leg, and forces perpendicular to it, are neglected.
        """
        xp, period = namespace(elapsed), elapsed.clip(1e-6, None)[:, None]
        force, rates, longer = along
        leg = self._leg
        pull = leg.mass * specific / period + (leg.moment + leg.mass * longer) * feet.turning**2
        change = (rates - self.rates) / period
        force = force - 0.5 * leg.damping * (rates + self.rates)
        force = force + pull - (leg.mass + leg.reflected_mass) * change
        follow = (period / max(self._config.force_filter, 1e-6)).clip(0.0, 1.0)
        force = self.forces + follow * (force * feet.axes[..., 2] - self.forces)
        return xp.where(self.fresh[:, None], 0.0, force)

    def _pushed(self, measured: RobotState) -> Array:
        """Force of the motors along the legs (N, 2) [N]."""
        torques, joints = measured.motor_torques, measured.joint_positions
        if self._geometry.knee is None:
            return torques @ self._slide_efforts
        forces = [
            ((torques @ motors) * leg_extension_jacobian(self._geometry, joints, leg)).sum(-1)
            for leg, motors in enumerate(self._legs)
        ]
        return namespace(joints).stack(forces, axis=1)


def _odometry(feet: FootMotion) -> tuple[Array, Array]:
    """Velocity (N, 2, 3) and height (N, 2) of the base if a foot's lower end is at rest."""
    xp, heights = namespace(feet.positions), feet.positions[..., 2]
    toe = 1.0 / (1.0 + xp.exp((heights[..., 1] - heights[..., 0]) / _END_SCALE))
    ends = xp.stack([1.0 - toe, toe], axis=-1)
    return -(ends[..., None] * feet.velocities).sum(2), -(ends * heights).sum(2)
