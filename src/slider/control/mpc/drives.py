"""Torques on both feet and on one: what the whole-body QP is asked for.

Both give torques (n, 12) [N m or N] and whether the QP has a solution (n,).
"""

import numpy as np

from slider.config.control import MpcConfig
from slider.config.robot import RobotConfig
from slider.control.mpc import lip
from slider.control.mpc.clock import TickClock
from slider.control.mpc.memory import FEET, Gait
from slider.control.mpc.motion import Motion, Part, join
from slider.control.mpc.nominal import Dynamics
from slider.control.mpc.whole_body import WholeBody

Solved = tuple[np.ndarray, np.ndarray]


class Drives:
    """Turns references of n robots into torques.

    Args:
        robot: the nominal robot.
        config: settings of the baseline.
        height: of the pendulum [m].
        clock: for the parts ``assembly`` and ``solution``.
    """

    def __init__(
        self, robot: RobotConfig, config: MpcConfig, height: float, clock: TickClock
    ) -> None:
        self._config, self._height, self._clock = config, height, clock
        self._omega = lip.rate(height)
        self._motion = Motion(config.whole_body)
        self._whole_body = WholeBody(robot, config.whole_body)

    def on_both_feet(
        self,
        gait: Gait,
        robots: np.ndarray,
        dynamics: Dynamics,
        contact: np.ndarray,
        wanted: np.ndarray,
    ) -> Solved:
        """Centre of mass as ``wanted``; feet without ``contact`` (n, 2) search the ground.

        ``wanted`` (n, 2, 3): forward and leftward place from the middle of the feet [m], velocity,
        acceleration.
        """
        position = gait.to_heading(dynamics.com[:, :2], robots)
        velocity = gait.to_heading(dynamics.com_velocity[:, :2], robots)
        task = self._config.whole_body.com
        error = wanted[:, :, 0] - (position - gait.sway.middle[robots])
        flat = wanted[:, :, 2] + task.kp * error + task.kd * (wanted[:, :, 1] - velocity)
        flat = gait.to_world(flat, robots)
        ground = dynamics.foot_positions[:, :, 2].mean(axis=1)
        weight = np.ones(3) * max(task.weight)
        feet = np.tile(FEET, (len(robots), 1))
        sinking = np.where(contact, 0.0, self._config.swing.search_velocity)
        parts = [
            *self._body(gait, robots, dynamics, flat, ground, weight),
            self._motion.stance(dynamics, feet, sinking),
        ]
        return self._solve(dynamics, parts, feet, contact)

    def on_one_foot(self, gait: Gait, robots: np.ndarray, dynamics: Dynamics) -> Solved:
        """The pendulum falls freely over the stance foot; the other one follows its reference."""
        config, stance = self._config, gait.stance[robots]
        support = dynamics.foot_positions[np.arange(len(robots)), stance]
        flat = self._omega**2 * (dynamics.com - support)[:, :2]
        weight = np.array(config.whole_body.com.weight)
        foot, yaw_rate = 1 - stance, gait.yaw_rate(robots)
        heading = gait.heading[robots] + 0.5 * yaw_rate * config.step.time
        feet = stance[:, None]
        parts = [
            *self._body(gait, robots, dynamics, flat, support[:, 2], weight),
            self._motion.swing(dynamics, foot, gait.swing[robots]),
            self._motion.swing_rotation(dynamics, foot, heading, yaw_rate),
            self._motion.stance(dynamics, feet, np.zeros(feet.shape)),
        ]
        return self._solve(dynamics, parts, feet, np.ones(feet.shape, dtype=bool))

    def _body(
        self,
        gait: Gait,
        robots: np.ndarray,
        dynamics: Dynamics,
        flat: np.ndarray,
        ground: np.ndarray,
        weight: np.ndarray,
    ) -> list[Part]:
        """Centre of mass with level acceleration ``flat`` (n, 2) above ``ground`` (n,), base."""
        lift = self._lift(dynamics, ground)
        acceleration = np.concatenate([flat, lift[:, None]], axis=1)
        return [
            self._motion.com(dynamics, acceleration, weight),
            self._motion.base(dynamics, gait.heading[robots], gait.yaw_rate(robots)),
        ]

    def _lift(self, dynamics: Dynamics, ground: np.ndarray) -> np.ndarray:
        """Vertical acceleration (n,) that holds the pendulum's height above the ground."""
        task = self._config.whole_body.com
        error = self._height - (dynamics.com[:, 2] - ground)
        return task.kp * error - task.kd * dynamics.com_velocity[:, 2]

    def _solve(
        self, dynamics: Dynamics, parts: list[Part], feet: np.ndarray, loaded: np.ndarray
    ) -> Solved:
        with self._clock.part("assembly"):
            problem = self._whole_body.build(dynamics, join(parts), feet, loaded)
        with self._clock.part("solution"):
            return self._whole_body.solve(problem)
