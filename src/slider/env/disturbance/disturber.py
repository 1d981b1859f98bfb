"""Everything that disturbs the robots of a batch, as the physics applies it."""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

from dataclasses import replace
from typing import Any, Protocol

import mujoco
import numpy as np

from slider.config.robot import RobotConfig
from slider.config.types import Interval
from slider.core.arrays import NUMPY, Array, beside, namespace, put, rows, which, zeros
from slider.env.disturbance import machines, sensing, terrain
from slider.env.disturbance.delay import DelayLine
from slider.env.disturbance.draws import GROUND, NOISE, PUSH, ROBOT, Disturbance, Draws
from slider.env.ground import FLAT, Ground, random_tile
from slider.env.state import RobotState
from slider.robot.mjcf import Actuation, SimulationOptions, build_spec, compile_spec
from slider.robot.transmission import Transmission

_PLACE = 2  # columns of the place on the ground, then one of the delay, then the machine's


def build_plant(
    robot: RobotConfig, options: SimulationOptions, disturbance: Disturbance | None
) -> mujoco.MjModel:
    """The nominal robot on the ground of the disturbance."""
    spec = build_spec(robot, options)
    if disturbance is not None and disturbance.config.ground.amplitude > 0:
        terrain.lay(spec, disturbance.config.ground, _tile(disturbance))
    return compile_spec(spec)


def _tile(disturbance: Disturbance) -> np.ndarray:
    """Heights of the ground: one for all robots, of the first seed."""
    generator = Draws(disturbance.seeds[:1], 1).generators(GROUND, 0)[0]
    return random_tile(disturbance.config.ground, generator)


class Robots(Protocol):
    """Robots that differ, drawn anew per robot and episode; of arrays or of tensors.

    Attributes:
        motor_gain: (N, 10) by which demanded torques are scaled [-].
    """

    motor_gain: Any

    @property
    def masses(self) -> Any:
        """Of the robots (N,) [kg]."""

    def draw(self, index: Any, uniform: Any, /) -> None:
        """Make robots ``index`` anew from numbers (N, ``machines.COLUMNS``) in [0, 1)."""


class Disturber:
    """Late drives, pushes, uneven ground and noisy sensors of N robots, which may differ.

    All arrays are beside ``like``; an index and its rows are those of ``core.arrays``. With tensors
    nothing waits for their device, and the ground is flat.
    """

    def __init__(
        self,
        disturbance: Disturbance,
        robot: RobotConfig,
        model: mujoco.MjModel,
        actuation: Actuation,
        count: int,
        robots: Robots | None = None,
        like: Any = NUMPY,
    ) -> None:
        """Disturb ``count`` robots with the drives of ``model``.

        Args:
            disturbance: what disturbs them.
            robot: for its feet and motors.
            model: of the nominal robot.
            actuation: of the drives.
            count: number of robots N.
            robots: how they differ; none where all are nominal.
            like: an array of the library, precision and device to compute with.
        """
        config = disturbance.config
        self._config, self._count, self._like = config, count, like
        self._timestep, self._mass = float(model.opt.timestep), float(model.body_mass.sum())
        self._torque = actuation == "torque"
        self._draws = Draws(disturbance.seeds, count, like)
        self._terrain: terrain.Terrain | None = None
        if config.ground.amplitude > 0:
            self._terrain = terrain.Terrain(config.ground, robot, _tile(disturbance), count)
        self._robots = robots
        self._delay: DelayLine | None = None
        if config.delay != Interval(0.0, 0.0):
            self._delay = DelayLine(config.delay, self._timestep, count, model.nu, like)
        self._motors = beside(Transmission.of(robot), like)
        self.restart()

    def restart(self) -> None:
        """Begin again: the same draws follow."""
        self._steps, self._episodes = 0, 0
        self._age = zeros(self._count, self._like, namespace(self._like).int64)

    def begin(self, index: Array, qpos: Array) -> Array:
        """Draw robots ``index`` anew; return where positions (n, 19) put them in the simulation."""
        uniform = self._draws.uniform(ROBOT, self._episodes, _PLACE + 1 + machines.COLUMNS)
        self._episodes += 1
        put(self._age, index, 0)
        if self._robots is not None:
            self._robots.draw(index, uniform[:, _PLACE + 1 :])
        if self._delay is not None:
            self._delay.draw(index, uniform[:, _PLACE])
            held = self._motors.angles(qpos[:, 7:])
            # Until the first input arrives the motors hold the pose, or are without torque.
            self._delay.fill(index, namespace(held).zeros_like(held) if self._torque else held)
        if self._terrain is None:
            return qpos
        return self._terrain.place(index, qpos, uniform[:, :_PLACE])

    def push(self, qvel: Array) -> None:
        """Add to the base velocities of robots whose time it is, in place in (N, 18)."""
        push, age = self._config.push, self._age
        if push.speed == 0:
            return
        due = which((age > 0) & (age % round(push.interval / self._timestep) == 0))
        if not len(due):  # a mask has all robots
            return
        xp, base = namespace(qvel), qvel[:, :2]
        angle = 2 * np.pi * rows(self._draws.uniform(PUSH, self._steps, 1), due)[:, 0]
        change = push.speed * xp.stack([xp.cos(angle), xp.sin(angle)], axis=1)
        put(base, due, rows(base, due) + change)

    def drive(self, control: Array) -> Array:
        """What reaches the drives (N, S, 10) in S simulation steps, of inputs of this shape."""
        self._steps += control.shape[1]
        self._age += control.shape[1]
        if self._delay is not None:
            control = self._delay.pass_on(control)
        if self._robots is not None and self._torque:
            control = control * self._robots.motor_gain[:, None]
        return control

    def sense(self, state: RobotState) -> RobotState:
        """The state with sensor noise."""
        if not sensing.noisy(self._config.sensing):
            return state
        normal = self._draws.normal(NOISE, self._steps, sensing.COLUMNS)
        return sensing.measure(state, self._config.sensing, normal)

    def wrap(self, qpos: np.ndarray) -> None:
        """Keep the robots on the height field, in place in positions (N, 19)."""
        if self._terrain is not None:
            self._terrain.wrap(qpos)

    @property
    def masses(self) -> Array:
        """Of the robots (N,) [kg]."""
        if self._robots is not None:
            return self._robots.masses
        return zeros(self._count, self._like) + self._mass

    @property
    def ground(self) -> Ground:
        """On which the robots are, in their own world."""
        return FLAT if self._terrain is None else self._terrain.ground

    @property
    def sensor_offset(self) -> np.ndarray:
        """Places (N, 2) in the robots' own world minus those of the sensors [m]."""
        return np.zeros((self._count, 2)) if self._terrain is None else self._terrain.sensor_offset

    def in_world(self, state: RobotState) -> RobotState:
        """The state in the robots' own world, of a state on the height field."""
        if self._terrain is None:
            return state
        base, feet = state.base_position.copy(), state.foot_positions.copy()
        base[:, :2] += self._terrain.offset
        feet[:, :, :2] += self.sensor_offset[:, None]
        return replace(state, base_position=base, foot_positions=feet, ground=self.ground)
