"""Everything that disturbs the robots of a batch, as the physics applies it."""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

from dataclasses import replace

import mujoco
import numpy as np

from slider.config.robot import RobotConfig
from slider.config.types import Interval
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


class Disturber:
    """Robots that differ, late drives, pushes, uneven ground and noisy sensors of N robots.

    Attributes:
        models: one for all robots, or one for each.
        masses: of the robots (N,) [kg].
    """

    def __init__(
        self,
        disturbance: Disturbance,
        robot: RobotConfig,
        model: mujoco.MjModel,
        actuation: Actuation,
        count: int,
    ) -> None:
        config = disturbance.config
        self._config, self._count = config, count
        self._timestep = float(model.opt.timestep)
        self._torque = actuation == "torque"
        self._draws = Draws(disturbance.seeds, count)
        self._terrain: terrain.Terrain | None = None
        if config.ground.amplitude > 0:
            self._terrain = terrain.Terrain(config.ground, robot, _tile(disturbance), count)
        self._machines = machines.Machines(model, config, count) if machines.vary(config) else None
        self.models = model if self._machines is None else self._machines.models
        self.masses = np.full(count, float(model.body_mass.sum()))
        self._delay: DelayLine | None = None
        if config.delay != Interval(0.0, 0.0):
            self._delay = DelayLine(config.delay, self._timestep, count, model.nu)
        self._motors = Transmission.of(robot)
        self.restart()

    def restart(self) -> None:
        """Begin again: the same draws follow."""
        self._steps, self._episodes = 0, 0
        self._age = np.zeros(self._count, dtype=int)

    def begin(self, index: np.ndarray, qpos: np.ndarray) -> np.ndarray:
        """Draw robots ``index`` anew; return where positions (n, 19) put them in the simulation."""
        uniform = self._draws.uniform(ROBOT, self._episodes, _PLACE + 1 + machines.COLUMNS)
        self._episodes += 1
        self._age[index] = 0
        if self._machines is not None:
            self._machines.draw(index, uniform[:, _PLACE + 1 :])
            self.masses[index] = self._machines.masses(index)
        if self._delay is not None:
            self._delay.draw(index, uniform[:, _PLACE])
            angles = self._motors.angles(qpos[:, 7:])
            # Until the first input arrives the motors hold the pose, or are without torque.
            self._delay.fill(index, np.zeros_like(angles) if self._torque else angles)
        if self._terrain is None:
            return qpos
        return self._terrain.place(index, qpos, uniform[:, :_PLACE])

    def push(self, qvel: np.ndarray) -> None:
        """Add to the base velocities of robots whose time it is, in place in (N, 18)."""
        push = self._config.push
        due = (self._age > 0) & (self._age % round(push.interval / self._timestep) == 0)
        if push.speed == 0 or not due.any():
            return
        angle = 2 * np.pi * self._draws.uniform(PUSH, self._steps, 1)[due, 0]
        qvel[due, :2] += push.speed * np.stack([np.cos(angle), np.sin(angle)], axis=1)

    def drive(self, control: np.ndarray) -> np.ndarray:
        """What reaches the drives (N, S, 10) in S simulation steps, of inputs of this shape."""
        self._steps += control.shape[1]
        self._age += control.shape[1]
        if self._delay is not None:
            control = self._delay.pass_on(control)
        if self._machines is not None and self._torque:
            control = control * self._machines.motor_gain[:, None]
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
