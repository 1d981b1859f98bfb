"""What moves: a simulated robot with an agent, or a gait replayed without physics."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np
import torch

from slider.config.control import AnyControl
from slider.config.disturbance import DisturbanceConfig
from slider.config.env import EnvConfig, PlantConfig, StartNoise
from slider.config.robot import RobotConfig
from slider.control.hzd.gaits import EnforcedGaits
from slider.control.model_based import build_controller, build_plant
from slider.control.policy import PolicyController, agent_of
from slider.control.policy_file import Policy
from slider.env.disturbance import Disturbance
from slider.env.interface import AgentInterface
from slider.env.physics import BatchedPhysics
from slider.env.rollout import Episode, Frame
from slider.env.starts import at_rest, multiply_quaternions
from slider.library.lookup import StepTimes
from slider.library.reader import GaitLibrary
from slider.robot.kinematics import about_z
from slider.robot.names import NUM_JOINTS

Start = Callable[[], tuple[np.ndarray, np.ndarray]]


class Motion(Protocol):
    """Frames at a fixed period [s]."""

    period: float

    def start(self, velocity: np.ndarray) -> Frame:
        """First frame, commanded to ``velocity`` (3,)."""
        ...

    def step(self, velocity: np.ndarray) -> Frame:
        """Next frame, commanded to ``velocity`` (3,)."""
        ...

    def push(self, velocity: np.ndarray) -> None:
        """Change the base's velocity (2,) [m/s]."""


class Simulation:
    """One simulated robot and its controller.

    Args:
        episode: of one robot.
        period: between two frames [s].
        start: new start of the robot, positions (1, 19) and velocities (1, 18).
    """

    def __init__(self, episode: Episode, period: float, start: Start) -> None:
        self.period = period
        self._episode, self._start = episode, start

    def start(self, velocity: np.ndarray) -> Frame:
        """Place the robot at rest, with new noise."""
        return self._episode.start(*self._start(), velocity[None].copy())

    def step(self, velocity: np.ndarray) -> Frame:
        """Simulate one control period."""
        self._episode.set_velocity(velocity[None].copy())
        return self._episode.step()

    def push(self, velocity: np.ndarray) -> None:
        """Give the base an impulse."""
        self._episode.push(velocity)


class Replay:
    """A gait of the library over and over, along its course."""

    def __init__(self, library: GaitLibrary, command: Sequence[float], period: float) -> None:
        index = int(library.nearest(np.array([command]))[0])
        self.period = period
        self.command = library.velocities[index]
        self.velocity = self.command[:2]
        durations = library.step_time[index]
        self._duration = float(durations.sum())
        self._times = _sample_times(durations, library.samples.shape[1])
        joints = library.samples[index, :, :NUM_JOINTS]
        self._qpos = np.concatenate([library.base[index, :, :7], joints], axis=1)
        self._steps = 0

    def start(self, velocity: np.ndarray) -> Frame:
        """Begin with left stance; the command is the gait's own."""
        self._steps = 0
        return self._frame()

    def step(self, velocity: np.ndarray) -> Frame:
        """Next frame."""
        self._steps += 1
        return self._frame()

    def push(self, velocity: np.ndarray) -> None:
        """A replay has no physics to push."""

    def _frame(self) -> Frame:
        time = self._steps * self.period
        walks, since = divmod(time, self._duration)
        qpos = np.array([np.interp(since, self._times, column) for column in self._qpos.T])
        qpos[3:7] /= np.linalg.norm(qpos[3:7])
        if self.command[2]:
            self._turn(qpos, int(walks))
        else:
            qpos[:2] += walks * self._duration * self.velocity
        return Frame(time, qpos, self.velocity, failed=False)

    def _turn(self, qpos: np.ndarray, walks: int) -> None:
        """Move a pose (19,) on by a number of turning walks, in place."""
        angle = self.command[2] * self._duration
        axes = about_z(np.array([angle]))[0, :2, :2]
        walk = self._qpos[-1, :2] - axes @ self._qpos[0, :2]  # of the stance foot
        for _ in range(walks):
            qpos[:2] = walk + axes @ qpos[:2]
        turn = np.array([[np.cos(walks * angle / 2), 0.0, 0.0, np.sin(walks * angle / 2)]])
        qpos[3:7] = multiply_quaternions(turn, qpos[None, 3:7])[0]


def _sample_times(durations: np.ndarray, samples: int) -> np.ndarray:
    """Times (samples,) [s]: the last sample of a step and the first of the next coincide."""
    first, second = (np.linspace(0.0, duration, samples // 2) for duration in durations)
    return np.concatenate([first, durations[0] + second])


def simulate_policy(
    policy: Policy,
    robot: RobotConfig,
    env: EnvConfig,
    noise: StartNoise,
    seed: int,
    disturbance: DisturbanceConfig | None = None,
) -> Simulation:
    """A trained policy in its environment, on a robot with disturbances or without.

    Raises:
        UserError: the policy is for other observations or actions.
    """
    agent = agent_of(policy, robot, env, 1)
    return _simulate_network(robot, env, agent, policy.network, noise, seed, disturbance)


def simulate_model_based(
    robot: RobotConfig,
    plant: PlantConfig,
    config: AnyControl,
    gaits: EnforcedGaits | None,
    noise: StartNoise,
    seed: int,
    disturbance: DisturbanceConfig,
) -> Simulation:
    """A controller of ``conf/control`` on torque drives, as in its evaluation."""
    physics = build_plant(robot, plant.physics, config, 1, Disturbance(disturbance, (seed,)))
    controller = build_controller(robot, config, plant.physics, 1, gaits)
    episode = Episode(controller, physics, plant)
    return Simulation(episode, plant.control_period, _starts(robot, noise, seed))


def simulate_agent(
    robot: RobotConfig, env: EnvConfig, noise: StartNoise, seed: int, random: bool
) -> Simulation:
    """A smoke agent: it holds the nominal pose, or its actions are uniform in ±1."""
    times = StepTimes.constant(0.4)
    env = replace(env, action=replace(env.action, offset="nominal"))
    agent = AgentInterface(robot, env, 1, times)
    generator = torch.Generator().manual_seed(seed)

    def network(observations: torch.Tensor) -> torch.Tensor:
        if not random:
            return torch.zeros(1, NUM_JOINTS)
        return 2.0 * torch.rand(1, NUM_JOINTS, generator=generator) - 1.0

    return _simulate_network(robot, env, agent, network, noise, seed)


def _simulate_network(
    robot: RobotConfig,
    env: EnvConfig,
    agent: AgentInterface,
    network,
    noise: StartNoise,
    seed: int,
    disturbance: DisturbanceConfig | None = None,
) -> Simulation:
    controller = PolicyController(network, agent)
    disturbed = None if disturbance is None else Disturbance(disturbance, (seed,))
    physics = BatchedPhysics(robot, env.physics, 1, 1, disturbance=disturbed)
    episode = Episode(controller, physics, env)
    return Simulation(episode, env.control_period, _starts(robot, noise, seed))


def _starts(robot: RobotConfig, noise: StartNoise, seed: int) -> Start:
    """Starts at rest, each with new noise."""
    rng = np.random.default_rng(seed)
    return lambda: at_rest(robot, noise, rng, 1)
