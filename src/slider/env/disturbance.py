"""Disturbances of a batch of robots: input delay, pushes, terrain, sensor noise.

Random numbers are functions of a seed, a use and a time instead of draws from one generator: a
robot's disturbance at a time depends neither on the rate of its controller nor on which other
disturbances are enabled.
"""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

from collections.abc import Callable
from dataclasses import astuple, dataclass, replace
from typing import Any

import mujoco
import numpy as np

from slider.config.env import DisturbanceConfig, SensingConfig
from slider.config.robot import RobotConfig
from slider.config.types import Interval
from slider.core.arrays import Array, asarray, namespace, zeros
from slider.env import randomization, terrain
from slider.env.starts import NUMPY, SLIDES, rotate
from slider.env.state import RobotState
from slider.robot.kinematics import rotation_from_quaternion, turn_to_heading, yaw_of
from slider.robot.mjcf import Actuation, SimulationOptions, build_spec
from slider.robot.names import NUM_JOINTS
from slider.robot.transmission import Transmission

# Uses of random numbers.
ROBOT, NOISE, PUSH, GROUND, BIAS, READING, TILES, SCAN, SCAN_BIAS, DROP_OUT = range(10)
NUMBERS = 2 * NUM_JOINTS + 10  # standard normal numbers per robot in with_noise
_STREAM = 81  # keeps these generators apart from others of the same seed


@dataclass(frozen=True)
class Disturbance:
    """What disturbs N robots.

    Attributes:
        config: which disturbances, how large.
        seeds: the robots come in blocks of the same size, one for each seed.
    """

    config: DisturbanceConfig
    seeds: tuple[int, ...]


class SeededRandom:
    """Random numbers for ``count`` robots in blocks, each with its own seed.

    They are NumPy arrays, or tensors on the device of ``like``; the two have different values.
    """

    def __init__(self, seeds: tuple[int, ...], count: int, like: Array = NUMPY) -> None:
        if count % len(seeds):
            raise ValueError(f"expected {count} robots in {len(seeds)} blocks of the same size")
        self._seeds, self._block, self._like = seeds, count // len(seeds), like

    def uniform(self, use: int, time: int, columns: int) -> Array:
        """Numbers (N, columns) in [0, 1) for a use at a time."""
        return self._draw(use, time, columns, "uniform", "rand")

    def normal(self, use: int, time: int, columns: int) -> Array:
        """Standard normal numbers (N, columns) for a use at a time."""
        return self._draw(use, time, columns, "standard_normal", "randn")

    def _draw(self, use: int, time: int, columns: int, of_numpy: str, of_torch: str) -> Array:
        """Draw with a method of NumPy's generators, or with a function of torch."""
        shape, like, xp = (self._block, columns), self._like, namespace(self._like)
        if isinstance(like, np.ndarray):
            return xp.concat([getattr(g, of_numpy)(size=shape) for g in self.generators(use, time)])
        generator, blocks = xp.Generator(device=like.device), []
        options = {"generator": generator, "dtype": like.dtype, "device": like.device}
        for key in self._keys(use, time):
            generator.manual_seed(int(np.random.SeedSequence(key).generate_state(1, np.uint64)[0]))
            blocks.append(getattr(xp, of_torch)(shape, **options))
        return xp.concat(blocks)

    def generators(self, use: int, time: int) -> list[np.random.Generator]:
        """One NumPy generator per seed."""
        return [np.random.default_rng(key) for key in self._keys(use, time)]

    def _keys(self, use: int, time: int) -> list[list[int]]:
        return [[seed, _STREAM, use, time] for seed in self._seeds]


def build_plant(
    robot: RobotConfig, options: SimulationOptions, disturbance: Disturbance | None
) -> mujoco.MjModel:
    """The nominal robot on the ground of the disturbance."""
    spec = build_spec(robot, options)
    if disturbance is not None and has_terrain(disturbance.config):
        terrain.add_ground(spec)
    return spec.compile()


def has_terrain(config: DisturbanceConfig) -> bool:
    """Whether the ground of any robot is not flat."""
    return set(config.terrain.kinds) != {"flat"}


class DisturbanceModel:
    """Input delay, pushes, terrain and sensor noise of N robots, which may differ.

    Arrays have the type and device of ``like``; with tensors the ground must be flat. For robots
    that differ from the nominal ``model``, ``write`` writes the varied fields of their models.
    """

    def __init__(
        self,
        disturbance: Disturbance,
        robot: RobotConfig,
        model: mujoco.MjModel,
        actuation: Actuation,
        count: int,
        write: Callable[[Array, randomization.Fields], None] | None = None,
        like: Any = NUMPY,
        ground: terrain.Terrain | None = None,
    ) -> None:
        config = disturbance.config
        self._config, self._count, self._like = config, count, like
        self._timestep = float(model.opt.timestep)
        self._torque = actuation == "torque"
        self._draws = SeededRandom(disturbance.seeds, count, like)
        self._terrain, self._robots = ground, None
        if write is not None:
            self._robots = randomization.RandomizedRobots(model, config, count, write, like)
        self._delay: DelayLine | None = None
        if config.delay != Interval(0.0, 0.0):
            self._delay = DelayLine(config.delay, self._timestep, count, model.nu, like)
        self._columns = randomization.COLUMNS + model.nu
        self._to_motors = asarray(Transmission.of(robot).matrix.T, like)
        self.restart()

    @property
    def motor_gain(self) -> Array:
        """Factors (N or 1, 1, motors) on the motors' torques [-]."""
        if self._robots is None:
            return zeros((1, 1, len(self._to_motors[0])), self._like) + 1.0
        return self._robots.motor_gain[:, None]

    def restart(self) -> None:
        """Restart the sequence of draws."""
        self._steps, self._episodes = 0, 0
        self._age = zeros(self._count, self._like)
        self._force = zeros((self._count, 2), self._like)

    def begin(self, index: Array, qpos: Array) -> Array:
        """Draw new disturbances of robots ``index``; return positions (n, 19) on their ground."""
        uniform = self._draws.uniform(ROBOT, self._episodes, self._columns)
        self._age[index], self._force[index] = 0.0, 0.0
        if self._robots is not None:
            self._robots.draw(index, uniform)
        if self._terrain is not None:
            numbers = self._draws.uniform(GROUND, self._episodes, terrain.DRAWS)
            qpos = self._terrain.begin(index, qpos, numbers[index])
        self._episodes += 1
        if self._delay is not None:
            self._delay.draw(index, uniform[index, randomization.DELAY])
            # Until the first input arrives, the motors hold the pose or have no torque.
            held = qpos[:, 7:] @ self._to_motors
            self._delay.fill(index, 0.0 * held if self._torque else held)
        return qpos

    def push(self) -> Array | None:
        """Horizontal forces (N, 2) [N] on the bases until the next call; none without pushes."""
        push, age, xp = self._config.push, self._age, namespace(self._age)
        if push.impulse.upper == 0:
            return None
        since = age % round(push.interval / self._timestep)
        due = (age > 0) & (since == 0)
        if due.any():
            uniform = self._draws.uniform(PUSH, self._steps, 2)[due]
            angle = 2 * np.pi * uniform[:, 0]
            if push.direction is not None:
                angle = 0.0 * angle + push.direction
            impulse = push.impulse.lower + (push.impulse.upper - push.impulse.lower) * uniform[:, 1]
            force = impulse / push.duration
            self._force[due] = force[:, None] * xp.stack([xp.cos(angle), xp.sin(angle)], axis=1)
        over = since >= round(push.duration / self._timestep)
        self._force[over] = 0.0
        return self._force

    def drive(self, control: Array) -> Array:
        """Inputs that reach the drives in S simulation steps, from commanded ones (N, S, 10)."""
        self._steps += control.shape[1]
        self._age += control.shape[1]
        if self._delay is not None:
            control = self._delay.pass_on(control)
        if self._robots is not None and self._torque:
            control = control * self.motor_gain
        return control

    def measure(self, state: RobotState) -> RobotState:
        """The state with sensor noise."""
        if not any(astuple(self._config.sensing)):
            return state
        normal = self._draws.normal(NOISE, self._steps, NUMBERS)
        return with_noise(state, self._config.sensing, normal)


class DelayLine:
    """Delays the inputs of N robots, each by its own integer number of simulation steps.

    Arrays have the type and device of ``like``.

    Attributes:
        steps: delays (N,) in simulation steps.
    """

    def __init__(
        self, delay: Interval, timestep: float, count: int, width: int, like: Array = NUMPY
    ) -> None:
        self._lower, self._upper = round(delay.lower / timestep), round(delay.upper / timestep)
        self._integer = namespace(like).int64
        self.steps = namespace(like).asarray(zeros(count, like), dtype=self._integer) + self._lower
        self._past = zeros((count, self._upper, width), like)

    def draw(self, index: Array, uniform: Array) -> None:
        """Draw new delays of robots ``index`` from uniform numbers (n,) in [0, 1)."""
        later = (self._upper - self._lower + 1) * uniform
        self.steps[index] = self._lower + namespace(later).asarray(later, dtype=self._integer)

    def fill(self, index: Array, inputs: Array) -> None:
        """Set the inputs (n, width) that robots ``index`` get until their first one arrives."""
        self._past[index] = inputs[:, None]

    def pass_on(self, control: Array) -> Array:
        """Delay inputs (N, S, width), one per simulation step."""
        xp, count = namespace(control), control.shape[1]
        line = xp.concat([self._past, control], axis=1)
        self._past[...] = line[:, count:]
        now = xp.arange(count, device=control.device)
        robot = xp.arange(len(control), device=control.device)
        return line[robot[:, None], self._upper - self.steps[:, None] + now]


def with_noise(state: RobotState, config: SensingConfig, normal: Array) -> RobotState:
    """The state with sensor noise, from standard normal numbers (N, 34).

    Terminations and metrics use the true state. So do rewards, except for the filtered velocity and
    the heading error, which the agent computes from the measured state.

    The orientation is perturbed about the base's axes, and all that is derived from it accordingly.
    Horizontal position of the base, feet and contacts are exact.
    """
    xp, base = namespace(normal), normal[:, 2 * NUM_JOINTS :]
    positions, velocities = normal[:, :NUM_JOINTS], normal[:, NUM_JOINTS : 2 * NUM_JOINTS]
    quaternion = rotate(state.quaternion, config.orientation * base[:, :3])
    rotation = rotation_from_quaternion(quaternion)
    yaw = yaw_of(rotation)
    linear = state.linear_velocity + config.linear_velocity * base[:, 3:6]
    position = 1.0 * state.base_position
    position[:, 2] += config.base_height * base[:, 9]
    spread = np.where(SLIDES, config.slide_position, config.joint_position)
    rate = np.where(SLIDES, config.slide_velocity, config.joint_velocity)
    spread, rate = asarray(spread, normal), asarray(rate, normal)
    return replace(
        state,
        base_position=position,
        quaternion=quaternion,
        rotation=rotation,
        yaw=yaw,
        linear_velocity=linear,
        angular_velocity=state.angular_velocity + config.angular_velocity * base[:, 6:9],
        heading_velocity=turn_to_heading(xp.einsum("nij,nj->ni", rotation, linear), yaw),
        gravity=-rotation[:, 2, :],
        joint_positions=state.joint_positions + spread * positions,
        joint_velocities=state.joint_velocities + rate * velocities,
    )
