"""The agent's side of the robot: from state to observation, from action to the plant's inputs.

Training and evaluation use the same class, so that observations agree. All arrays are tensors.
"""

import math

import numpy as np
import torch

from slider.config.env import EnvConfig
from slider.config.robot import RobotConfig
from slider.core.arrays import tensors
from slider.core.errors import UserError
from slider.env.observations import Observer, reflect
from slider.env.phase import Clock, gait_velocity_of
from slider.env.state import RobotState, View
from slider.library.lookup import GaitTable, StepTimes
from slider.robot.mjcf import nominal_qpos
from slider.robot.names import MIRROR_PERMUTATION, NUM_JOINTS, SIDES, mirror_sign
from slider.robot.transmission import Transmission

FLOAT64 = torch.zeros(0, dtype=torch.float64)  # precision on the CPU
_PERMUTATION = np.array(MIRROR_PERMUTATION)


class AgentInterface:
    """Observations, actions, clock and heading target of N robots.

    ``times`` are for the clock, if there is one; ``reference`` has the gaits for actions that are
    offsets from a gait. Tensors have the precision and the device of ``like``.

    Raises:
        UserError: the configuration needs step times or gaits that are not given.
    """

    def __init__(
        self,
        robot: RobotConfig,
        config: EnvConfig,
        num_robots: int,
        times: StepTimes | None,
        reference: GaitTable | None = None,
        like: torch.Tensor = FLOAT64,
    ) -> None:
        if config.phase.enabled and times is None:
            raise UserError("env.phase.enabled: expected the step times of a gait library")
        about_gait = config.action.offset == "gait"
        if about_gait and reference is None:
            raise UserError("env.action.offset=gait: expected the gaits of a library, found none")
        self._reference = tensors(reference, like) if about_gait and reference else None
        self.observer = Observer(config.observation, robot.geometry)
        self.mirror_sign = np.array(mirror_sign(robot.geometry))
        self.num_robots = num_robots
        self._config = config
        nominal = nominal_qpos(robot)
        self.nominal, self.nominal_height = like.new_tensor(nominal[7:]), float(nominal[2])
        scale = [config.action.scale[name] for name in robot.geometry.leg_joints]
        self._scale = like.new_tensor(scale * len(SIDES))
        self._lower, self._upper = (like.new_tensor(limit) for limit in robot.joint_ranges)
        self._torque_limits = like.new_tensor(Transmission.of(robot).torque)
        self.clock: Clock | None = None
        if config.phase.enabled and times is not None:
            self.clock = Clock(times, config.control_period, num_robots, config.phase.halt, like)
        self.command = like.new_zeros(num_robots, 4)
        self.action = like.new_zeros(num_robots, NUM_JOINTS)
        self.previous_action = like.new_zeros(num_robots, NUM_JOINTS)
        self.filtered_velocity = like.new_zeros(num_robots, 2)
        self.reference_velocity = like.new_zeros(num_robots, 2)
        self.expected_velocity = like.new_zeros(num_robots, 2)
        self.heading_target = like.new_zeros(num_robots)
        self._no_phase = like.new_zeros(num_robots)
        self._none_halted = self._no_phase > 0

    def reset(
        self,
        index: torch.Tensor | slice,
        state: RobotState,
        phase: torch.Tensor | float = 0.0,
        velocity: torch.Tensor | float = 0.0,
        heading: torch.Tensor | None = None,
    ) -> None:
        """Reset the history of robots ``index``.

        Args:
            index, state: robots to reset; state of all robots after that.
            phase: initial phase of the clock, (n,) or one for all.
            velocity: initial reference and filtered velocity (n, 2) [m/s], or one value for all.
            heading: target (n,) [rad]; the current yaw if not given.
        """
        for values in (self.action, self.previous_action):
            values[index] = 0.0
        for values in (self.reference_velocity, self.filtered_velocity, self.expected_velocity):
            values[index] = velocity
        if self._at_once:
            self.reference_velocity[index] = self.command[index, :2]
        self.heading_target[index] = state.yaw[index] if heading is None else heading
        if self.clock is not None:
            speed = torch.hypot(*self.filtered_velocity[index].T)
            self.clock.reset(index, phase, self.command[index], speed)

    def set_velocity_command(self, index: torch.Tensor | slice, velocity: torch.Tensor) -> None:
        """Command vx, vy [m/s] and yaw rate [rad/s], (n, 3), to robots ``index``."""
        self.command[index, :3] = velocity
        if self._at_once:
            self.reference_velocity[index] = velocity[:, :2]

    def act(self, action: torch.Tensor) -> torch.Tensor:
        """Joint targets (N, 12) [rad or m] of the agent's actions (N, 12)."""
        action = action.to(self._scale).clip(-self._config.action.clip, self._config.action.clip)
        action = reflect(action, self._mirrored(), _PERMUTATION, self.mirror_sign)
        self.previous_action = self.action
        self.action = action.where(self._scale > 0, 0.0)
        origin = self.nominal  # (12,), or (N, 12) on gaits or standing
        if self._reference is not None and self.clock is not None:
            velocity = gait_velocity_of(self.reference_velocity, self.command)
            gait = self._reference.at(velocity, self.clock.phase)
            origin = self._reference.standing.where(self.clock.halted[:, None], gait)
        return (origin + self._scale * self.action).clip(self._lower, self._upper)

    def advance(self, state: RobotState) -> None:
        """Advance clock, heading target, reference and velocity filters by one control period."""
        period = self._config.control_period
        if self.clock is not None:
            velocities = self.filtered_velocity, state.heading_velocity
            speeds = (torch.hypot(*velocity.T) for velocity in velocities)
            self.clock.advance(self.command, self.reference_velocity, *speeds)
        self.heading_target += self.command[:, 2] * period
        change = self._config.reference.acceleration * period
        way = self.command[:, :2] - self.reference_velocity
        self.reference_velocity += way if self._at_once else way.clip(-change, change)
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
        self.command[:, 3] = (error + math.pi) % (2 * math.pi) - math.pi

    def view(self, state: RobotState) -> View:
        """Everything that terms may read."""
        return View(
            state=state,
            command=self.command,
            action=self.action,
            previous_action=self.previous_action,
            action_scale=self._scale,
            filtered_velocity=self.filtered_velocity,
            reference_velocity=self.reference_velocity,
            expected_velocity=self.expected_velocity,
            phase=self._no_phase if self.clock is None else self.clock.phase,
            halted=self._none_halted if self.clock is None else self.clock.halted,
            nominal=self.nominal,
            nominal_height=self.nominal_height,
            torque_limits=self._torque_limits,
            period=self._config.control_period,
            scan=self._config.observation.height_scan,
        )

    def observe(self, state: RobotState) -> torch.Tensor:
        """Observations (N, size) float32."""
        return self.observer(self.view(state), self._mirrored())

    def _mirrored(self) -> torch.Tensor:
        """Robots whose observations and actions are reflected: those in right stance."""
        if self.clock is None or not self._config.phase.mirror:
            return self._none_halted
        return self.clock.phase >= 0.5
