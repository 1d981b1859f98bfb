"""The agent's side of the robot: from state to observation, from action to the plant's inputs.

Training and evaluation use this same object, so that observations agree.
"""

import numpy as np

from slider.config.env import EnvConfig
from slider.config.robot import RobotConfig
from slider.core.errors import UserError
from slider.env.observations import Observer
from slider.env.phase import Clock, StepClock
from slider.env.starts import joint_range
from slider.env.state import RobotState
from slider.env.underlying import NOBODY, Underlying, UnderlyingController
from slider.env.view import View
from slider.library.joint_table import JointTable
from slider.library.step_times import StepTimes
from slider.robot.mjcf import nominal_qpos
from slider.robot.names import (
    JOINTS,
    MIRROR_PERMUTATION,
    MIRROR_SIGN,
    NUM_JOINTS,
    SIDES,
    leg_joint,
)
from slider.robot.transmission import Transmission, by_motor

_PERMUTATION = np.array(MIRROR_PERMUTATION)
_SIGN = np.array(MIRROR_SIGN)


class AgentInterface:
    """Observations, actions, clock and heading target of N robots.

    Args:
        robot, config: machine, observations and actions.
        num_robots: N.
        times: step times for the clock, if there is one.
        reference: joint positions of the gaits, if actions are about the gait.
        underlying: the controller under the actions, if there is one.

    Raises:
        UserError: the configuration needs step times, gaits or a controller that are not given.

    Attributes:
        controller: under the actions, or None.
        ticks: of the plant per control period.
    """

    def __init__(
        self,
        robot: RobotConfig,
        config: EnvConfig,
        num_robots: int,
        times: StepTimes | None,
        reference: JointTable | None = None,
        underlying: Underlying | None = None,
    ) -> None:
        if config.action.offset == "hzd" and underlying is None:
            raise UserError("env.action.offset=hzd: expected that controller, found none")
        if config.phase.enabled and times is None and underlying is None:
            raise UserError("env.phase.enabled: expected the step times of a gait library")
        about_gait = config.action.offset == "gait"
        if about_gait and reference is None:
            raise UserError("env.action.offset=gait: expected the gaits of a library, found none")
        self._reference = reference if about_gait else None
        self.observer = Observer(config.observation)
        self.num_robots = num_robots
        self._config = config
        nominal = nominal_qpos(robot)
        self.nominal, self.nominal_height = nominal[7:], float(nominal[2])
        self._scale = np.array([config.action.scale[leg_joint(name)] for name in JOINTS])
        self._lower, self._upper = joint_range(robot)
        self._motors = Transmission.of(robot)
        self._stiffness = np.array([gain.kp for gain in by_motor(robot.gains) * len(SIDES)])
        self.ticks = 1
        self.controller: UnderlyingController | None = None
        self.clock: Clock | StepClock | None = None
        if underlying is not None:
            physics = config.physics
            self.ticks = physics.substeps // underlying.substeps
            self.controller = underlying.controller(robot, underlying.substeps * physics.timestep)
            self.controller.allocate(num_robots)
            self.clock = StepClock(self.controller)
        elif config.phase.enabled and times is not None:
            self.clock = Clock(times, config.control_period, num_robots, config.phase.halt)
        self.command = np.zeros((num_robots, 4))
        self.action = np.zeros((num_robots, NUM_JOINTS))
        self.previous_action = np.zeros((num_robots, NUM_JOINTS))
        self.filtered_velocity = np.zeros((num_robots, 2))
        self.reference_velocity = np.zeros((num_robots, 2))
        self.expected_velocity = np.zeros((num_robots, 2))
        self.heading_target = np.zeros(num_robots)

    def reset(
        self,
        index: np.ndarray,
        state: RobotState,
        phase: np.ndarray | float = 0.0,
        velocity: np.ndarray | float = 0.0,
        heading: np.ndarray | None = None,
        walking: np.ndarray | bool = False,
    ) -> None:
        """Forget the past of robots ``index``.

        Args:
            index: robots to reset.
            state: of all robots, after their reset.
            phase: start of the clock, (n,) or one for all.
            velocity: start of reference and filters (n, 2) [m/s], or one value for all.
            heading: target (n,) [rad]; the present yaw if not given.
            walking: whether a controller under the actions begins at once with the step that
                ``phase`` is in (n,); else it starts at rest.
        """
        self.action[index] = 0.0
        self.previous_action[index] = 0.0
        self.reference_velocity[index] = self.command[index, :2] if self._at_once else velocity
        self.filtered_velocity[index] = self.expected_velocity[index] = velocity
        self.heading_target[index] = state.yaw[index] if heading is None else heading
        if self.clock is not None:
            speed = np.hypot(*self.filtered_velocity[index].T)
            self.clock.reset(index, phase, self.command[index], speed)
        if self.controller is not None:
            foot = np.broadcast_to(phase, index.shape) >= 0.5
            stance = np.where(walking, foot, NOBODY)
            velocity, target = self.command[index, :3], self.heading_target[index]
            self.controller.restart(index, state, velocity, target, stance)

    def set_velocity_command(self, index: np.ndarray, velocity: np.ndarray) -> None:
        """Command vx, vy [m/s] and yaw rate [rad/s], (n, 3), to robots ``index``."""
        self.command[index, :3] = velocity
        if self._at_once:
            self.reference_velocity[index] = velocity[:, :2]
        if self.controller is not None:
            self.controller.command(self.command[:, :3].copy())

    def act(self, action: np.ndarray) -> np.ndarray:
        """Joint targets (N, 12) [rad or m] of the agent's actions (N, 12).

        With a controller under the actions joint efforts [N m or N] that add to its own: those by
        which the motors' position loops would change if their targets moved as far.
        """
        action = np.clip(action, -self._config.action.clip, self._config.action.clip)
        mirrored = self._mirrored()
        action[mirrored] = action[mirrored][:, _PERMUTATION] * _SIGN
        self.previous_action = self.action
        self.action = np.where(self._scale > 0, action, 0.0)
        moved = self._scale * self.action
        if self.controller is not None:
            return self._motors.efforts(self._stiffness * self._motors.angles(moved))
        return np.clip(self._origin() + moved, self._lower, self._upper)

    def inputs(self, acted: np.ndarray, state: RobotState) -> np.ndarray:
        """The plant's inputs (N, 12) at a tick, from those of :meth:`act` and the state."""
        return acted if self.controller is None else acted + self.controller.control(state)

    def _origin(self) -> np.ndarray:
        """Joint positions of a zero action: (12,), or (N, 12) on gaits or standing."""
        if self._reference is None or self.clock is None:
            return self.nominal
        command = np.column_stack([self.reference_velocity, self.command[:, 2]])
        origin = self._reference.at(command, self.clock.phase)
        if self.clock.halted.any():
            origin[self.clock.halted] = self._reference.standing
        return origin

    def advance(self, state: RobotState) -> None:
        """Move clock, heading target, reference and velocity filters on by one control period."""
        period = self._config.control_period
        if self.clock is not None:
            speeds = (np.hypot(*v.T) for v in (self.filtered_velocity, state.heading_velocity))
            self.clock.advance(self.command, self.reference_velocity, *speeds)
        self.heading_target += self.command[:, 2] * period
        change = self._config.reference.acceleration * period
        way = self.command[:, :2] - self.reference_velocity
        self.reference_velocity += way if self._at_once else np.clip(way, -change, change)
        gain = self._config.observation.filter_gain(period)
        self.filtered_velocity += gain * (state.heading_velocity - self.filtered_velocity)
        self.expected_velocity += gain * (self.reference_velocity - self.expected_velocity)
        self.refresh_heading(state)

    @property
    def _at_once(self) -> bool:
        return self._config.reference.acceleration == 0.0

    def refresh_heading(self, state: RobotState) -> None:
        """Write the wrapped heading error into the command."""
        error = self.heading_target - state.yaw
        self.command[:, 3] = (error + np.pi) % (2 * np.pi) - np.pi

    def view(self, state: RobotState) -> View:
        """Everything that terms may read."""
        scan = self._config.observation.height_scan
        return View(
            state=state,
            command=self.command,
            action=self.action,
            previous_action=self.previous_action,
            action_scale=self._scale,
            filtered_velocity=self.filtered_velocity,
            reference_velocity=self.reference_velocity,
            expected_velocity=self.expected_velocity,
            phase=np.zeros(self.num_robots) if self.clock is None else self.clock.phase,
            halted=self._halted(),
            nominal=self.nominal,
            nominal_height=self.nominal_height,
            torque_limits=self._motors.torque,
            period=self._config.control_period,
            scan_points=(scan.points_x, scan.points_y),
            scan_spacing=scan.spacing,
        )

    def observe(self, state: RobotState) -> np.ndarray:
        """Observations (N, size) float32."""
        return self.observer(self.view(state), self._mirrored())

    def _halted(self) -> np.ndarray:
        if self.clock is None:
            return np.zeros(self.num_robots, dtype=bool)
        return self.clock.halted

    def _mirrored(self) -> np.ndarray:
        """Robots whose observations and actions are reflected: those in right stance."""
        if self.clock is None or not self._config.phase.mirror:
            return np.zeros(self.num_robots, dtype=bool)
        return ~self.clock.left_stance
