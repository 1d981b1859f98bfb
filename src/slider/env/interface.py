"""The agent's side of the robot: from state to observation, from action to the plant's inputs.

Training and evaluation use this same object, so that observations agree. A controller under the
actions computes with NumPy; everything else with the library of the arrays that it is given.
"""

import numpy as np

from slider.config.env import EnvConfig
from slider.config.robot import RobotConfig
from slider.core.arrays import NUMPY, Array, asarray, beside, namespace, put, rows, zeros
from slider.core.errors import UserError
from slider.env.observations import Observer, reflect
from slider.env.phase import Clock, StepClock, gait_command
from slider.env.starts import joint_range
from slider.env.state import RobotState
from slider.env.underlying import NOBODY, Underlying, UnderlyingController
from slider.env.view import View
from slider.library.lookup import JointTable, StepTimes
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
        like: an array of the library, and on the device, to compute with.

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
        like: Array = NUMPY,
    ) -> None:
        if config.action.offset == "hzd" and underlying is None:
            raise UserError("env.action.offset=hzd: expected that controller, found none")
        if config.phase.enabled and times is None and underlying is None:
            raise UserError("env.phase.enabled: expected the step times of a gait library")
        about_gait = config.action.offset == "gait"
        if about_gait and reference is None:
            raise UserError("env.action.offset=gait: expected the gaits of a library, found none")
        self._reference = beside(reference, like) if about_gait else None
        self.observer = Observer(config.observation)
        self.num_robots = num_robots
        self._config = config
        nominal = nominal_qpos(robot)
        self.nominal, self.nominal_height = asarray(nominal[7:], like), float(nominal[2])
        scale = np.array([config.action.scale[leg_joint(name)] for name in JOINTS])
        self._scale = asarray(scale, like)
        self._lower, self._upper = (asarray(limit, like) for limit in joint_range(robot))
        self._motors = beside(Transmission.of(robot), like)
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
            self.clock = Clock(times, config.control_period, num_robots, config.phase.halt, like)
        self.command = zeros((num_robots, 4), like)
        self.action = zeros((num_robots, NUM_JOINTS), like)
        self.previous_action = zeros((num_robots, NUM_JOINTS), like)
        self.filtered_velocity = zeros((num_robots, 2), like)
        self.reference_velocity = zeros((num_robots, 2), like)
        self.expected_velocity = zeros((num_robots, 2), like)
        self.heading_target = zeros(num_robots, like)
        self._no_phase = zeros(num_robots, like)
        self._nobody = self._no_phase != 0

    def reset(
        self,
        index: Array,
        state: RobotState,
        phase: Array | float = 0.0,
        velocity: Array | float = 0.0,
        heading: Array | None = None,
        walking: Array | bool = False,
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
        command, yaw = rows(self.command, index), rows(state.yaw, index)
        for array in (self.action, self.previous_action):
            put(array, index, 0.0)
        for array in (self.reference_velocity, self.filtered_velocity, self.expected_velocity):
            put(array, index, velocity)
        if self._at_once:
            put(self.reference_velocity, index, command[:, :2])
        put(self.heading_target, index, yaw if heading is None else heading)
        if self.clock is not None:
            speed = _norm(rows(self.filtered_velocity, index))
            self.clock.reset(index, phase, command, speed)
        if self.controller is not None:
            foot = np.broadcast_to(phase, index.shape) >= 0.5
            stance = np.where(walking, foot, NOBODY)
            target = self.heading_target[index]
            self.controller.restart(index, state, command[:, :3], target, stance)

    def set_velocity_command(self, index: Array, velocity: Array) -> None:
        """Command vx, vy [m/s] and yaw rate [rad/s], (n, 3), to robots ``index``."""
        put(self.command[:, :3], index, velocity)
        if self._at_once:
            put(self.reference_velocity, index, velocity[:, :2])
        if self.controller is not None:
            self.controller.command(self.command[:, :3].copy())

    def act(self, action: Array) -> Array:
        """Joint targets (N, 12) [rad or m] of the agent's actions (N, 12).

        With a controller under the actions joint efforts [N m or N] that add to its own: those by
        which the motors' position loops would change if their targets moved as far.
        """
        action = action.clip(-self._config.action.clip, self._config.action.clip)
        action = reflect(action, self._mirrored(), _PERMUTATION, _SIGN)
        self.previous_action = self.action
        self.action = namespace(action).where(self._scale > 0, action, 0.0)
        moved = self._scale * self.action
        if self.controller is not None:
            return self._motors.efforts(self._stiffness * self._motors.angles(moved))
        return (self._origin() + moved).clip(self._lower, self._upper)

    def inputs(self, acted: Array, state: RobotState) -> Array:
        """The plant's inputs (N, 12) at a tick, from those of :meth:`act` and the state."""
        return acted if self.controller is None else acted + self.controller.control(state)

    def _origin(self) -> Array:
        """Joint positions of a zero action: (12,), or (N, 12) on gaits or standing."""
        if self._reference is None or self.clock is None:
            return self.nominal
        command = gait_command(self.reference_velocity, self.command)
        origin, halted = self._reference.at(command, self.clock.phase), self.clock.halted
        return namespace(origin).where(halted[:, None], self._reference.standing, origin)

    def advance(self, state: RobotState) -> None:
        """Move clock, heading target, reference and velocity filters on by one control period."""
        period = self._config.control_period
        if self.clock is not None:
            speeds = (_norm(v) for v in (self.filtered_velocity, state.heading_velocity))
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
            phase=self._no_phase if self.clock is None else self.clock.phase,
            halted=self._nobody if self.clock is None else self.clock.halted,
            nominal=self.nominal,
            nominal_height=self.nominal_height,
            torque_limits=self._motors.torque,
            period=self._config.control_period,
            scan_points=(scan.points_x, scan.points_y),
            scan_spacing=scan.spacing,
        )

    def observe(self, state: RobotState) -> Array:
        """Observations (N, size) float32."""
        return self.observer(self.view(state), self._mirrored())

    def _mirrored(self) -> Array:
        """Robots whose observations and actions are reflected: those in right stance."""
        if self.clock is None or not self._config.phase.mirror:
            return self._nobody
        return ~self.clock.left_stance


def _norm(vectors: Array) -> Array:
    """Lengths (n,) of vectors (n, 2)."""
    return namespace(vectors).hypot(vectors[:, 0], vectors[:, 1])
