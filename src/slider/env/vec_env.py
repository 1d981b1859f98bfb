"""The training environment: a task on batched physics behind rsl-rl's ``VecEnv`` interface."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import torch
from rsl_rl.env import VecEnv
from tensordict import TensorDict

from slider.config.env import EnvConfig
from slider.config.robot import RobotConfig
from slider.config.train import TrainConfig, VelocitiesConfig
from slider.env import terminations
from slider.env.disturbance import Disturbance
from slider.env.guide import Guide
from slider.env.interface import AgentInterface
from slider.env.phase import standing
from slider.env.physics import BatchedPhysics
from slider.env.rewards import Reward, RewardView
from slider.env.starts import at_rest, sample_about
from slider.env.state import RobotState
from slider.library.lookup import GaitTable, StepTimes
from slider.library.reader import GaitLibrary
from slider.robot.names import GAIT_JOINTS, NUM_JOINTS

_CROSSED = 1.0  # distance in an episode after which its terrain counts as crossed [m]


@dataclass(frozen=True)
class Task:
    """One training.

    Attributes:
        robot, env, train: the configuration.
        times: step times of the clock, where there is one.
        guide: the library's gaits for guide rewards and starts; none where training is unguided.
        reference: joint positions of the gaits, where actions are about the gait.
    """

    robot: RobotConfig
    env: EnvConfig
    train: TrainConfig
    times: StepTimes | None
    guide: Guide | None
    reference: GaitTable | None = None


def task_of(
    robot: RobotConfig,
    env: EnvConfig,
    train: TrainConfig,
    library: Path | None,
    guided: bool = True,
) -> Task:
    """The task of a configuration and a Zarr gait library, if the training has one.

    The clock has a fixed step time or those of the gaits. Only a ``guided`` training has rewards
    and starts that use the gaits.
    """
    times = StepTimes.constant(env.phase.step_time) if env.phase.step_time > 0 else None
    if library is None:
        return Task(robot, env, train, times if env.phase.enabled else None, None)
    gaits = GaitLibrary.load(library)
    table = GaitTable.from_library(gaits)
    return Task(
        robot,
        env,
        train,
        (times or table.times) if env.phase.enabled else None,
        Guide(gaits, table, robot.geometry, train.guide.gait) if guided else None,
        table.joints if env.action.offset == "gait" else None,
    )


class Random:
    """Random numbers of a seed in the precision and on the device of ``like``."""

    def __init__(self, seed: int, like: torch.Tensor) -> None:
        self._generator = torch.Generator(like.device).manual_seed(seed)
        self._options: dict[str, Any] = {"dtype": like.dtype, "device": like.device}

    def uniform(self, low: Any = 0.0, high: Any = 1.0, size: Any = ()) -> torch.Tensor:
        """Uniform numbers in [low, high) of a shape."""
        share = torch.rand(size, generator=self._generator, **self._options)
        return low + (high - low) * share

    def standard_normal(self, size: Any = ()) -> torch.Tensor:
        """Standard normal numbers of a shape."""
        return torch.randn(size, generator=self._generator, **self._options)


class VelocitySampler:
    """Draws velocities: vx, vy [m/s] and yaw rate [rad/s], on the device of ``like``."""

    def __init__(self, config: VelocitiesConfig, control_period: float, like: torch.Tensor) -> None:
        self._standing_fraction = config.standing_fraction
        ranges = (config.vx, config.vy, config.yaw_rate)
        self._lower = like.new_tensor([r.lower for r in ranges])
        self._upper = like.new_tensor([r.upper for r in ranges])
        self._change = control_period / config.period if config.period > 0 else 0.0

    def sample(self, rng: Random, count: int) -> torch.Tensor:
        """New velocities (count, 3) within the ranges; a fraction of them is zero."""
        velocities = rng.uniform(self._lower, self._upper, (count, 3))
        standing = rng.uniform(size=(count, 1)) < self._standing_fraction
        return velocities.masked_fill_(standing, 0.0)

    def changing(self, rng: Random, num_robots: int) -> torch.Tensor:
        """Indices (n,) of the robots that get a new velocity in this control step."""
        if self._change == 0.0:
            return torch.zeros(0, dtype=torch.long, device=self._lower.device)
        return (rng.uniform(size=num_robots) < self._change).nonzero().flatten()


class WalkingEnv(VecEnv):
    """N robots with commanded velocities; an episode ends at a fall or at its maximum length.

    Observations: TensorDict with ``policy`` (N, size) float32. Actions: (N, 12).
    ``extras``: ``time_outs`` (N,) and ``log`` with the mean of every reward term.
    Commands, starts and phases follow from the training's seed.

    Tensors have the device and the precision of the physics. On the CPU they share the memory of
    MuJoCo's arrays.

    Attributes:
        physics: the simulated robots.
        agent: their observations, actions, clock and commands.
        reward: the configured sum of terms.
        diverged: (1,) simulations that blew up so far.
    """

    def __init__(
        self, task: Task, threads: int = 1, simulate: Callable[..., Any] | None = None
    ) -> None:
        robot, config, train = task.robot, task.env, task.train
        terminations.check(config.termination.terms)
        self.num_envs = train.robots
        self.num_actions = NUM_JOINTS
        self.max_episode_length = round(train.episode_length / config.control_period)
        self.cfg: dict | object = config
        self._robot, self._config, self._train = robot, config, train
        simulate = simulate or partial(
            BatchedPhysics, threads=threads, instruments=False, onboard=config.estimation
        )
        self.physics = simulate(
            robot,
            config.physics,
            self.num_envs,
            disturbance=Disturbance(train.disturbance, (train.seed,)),
        )
        like = self._like = torch.as_tensor(self.physics.qpos[:0])
        self.device = like.device
        self.episode_length_buf = torch.zeros(self.num_envs, dtype=torch.long, device=self.device)
        self.diverged = like.new_zeros(1)
        self._rng = Random(train.seed, like)
        self._guide = None if task.guide is None else task.guide.on(like)
        self.agent = AgentInterface(robot, config, self.num_envs, task.times, task.reference, like)
        self._commands = VelocitySampler(train.velocities, config.control_period, like)
        self._share: torch.Tensor | None = None  # factors on the drawn velocities
        if self.physics.terrain is not None:
            self._share = like.new_tensor(self.physics.terrain.speeds(train.velocities.uneven))
        self.reward = Reward(train.reward)
        self._outputs = like.new_full((self.num_envs, 2, len(GAIT_JOINTS)), math.inf)
        self.restart()

    @property
    def terrain_levels(self) -> list[float]:
        """Levels of the robots' terrain (N,); none on flat ground."""
        terrain = self.physics.terrain
        return [] if terrain is None else terrain.levels.tolist()

    def restore_levels(self, levels: list[float]) -> None:
        """Restart all robots on terrain of these levels (N,)."""
        if self.physics.terrain is not None:
            self.physics.terrain.levels[:] = levels
            self.restart()

    def restart(self) -> None:
        """Restart all robots."""
        self._reset(torch.arange(self.num_envs, device=self.device))
        self.episode_length_buf[:] = 0
        self._observe()

    def get_observations(self) -> TensorDict:
        """Current observations."""
        return self._observations

    def step(self, actions: torch.Tensor) -> tuple[TensorDict, torch.Tensor, torch.Tensor, dict]:
        """Simulate one control period of all robots."""
        self.physics.step(self.agent.act(actions.to(self.device)))
        state = self._read()
        self.agent.advance(self._measured)
        fell = terminations.failed(state, self._config.termination.terms)
        view = self.agent.view(state)
        seen = RewardView(view, self._guide, self._outputs)
        reward, parts = self.reward(seen, fell)
        if "outputs" in vars(seen):  # a term read them
            self._outputs = seen.outputs.clone()
        speed_error = abs(view.filtered_velocity[:, 0] - view.command[:, 0])
        self.diverged += state.diverged.sum()
        timed_out = self._end_episodes(fell, state)
        index = self._commands.changing(self._rng, self.num_envs)
        if len(index):
            self.agent.set_velocity_command(index, self._draw_velocities(index))
        self._observe()
        log: dict[str, Any] = {f"/reward/{name}": value.mean() for name, value in parts.items()}
        log["/episode/falls_per_second"] = (1.0 * fell).mean() / self._config.control_period
        log["/episode/speed_error"] = speed_error.mean()
        log["/episode/diverged"] = (1.0 * state.diverged).sum()
        if self.physics.terrain is not None:
            log["/episode/terrain_level"] = self.physics.terrain.mean_level
        extras = {"time_outs": timed_out.float(), "log": log}
        return self._observations, reward.float(), (fell | timed_out).long(), extras

    def _read(self) -> RobotState:
        """Read the true state and store the measured one."""
        state = self.physics.read()
        self._measured = self.physics.measure(state).tensors(self._like)
        return state.tensors(self._like)

    def _end_episodes(self, fell: torch.Tensor, state: RobotState) -> torch.Tensor:
        """Reset robots that fell or timed out; return those (N,) that timed out."""
        self.episode_length_buf += 1
        timed_out = (self.episode_length_buf >= self.max_episode_length) & ~fell
        ended = fell | timed_out
        if self.physics.terrain is not None:
            crossed = timed_out & (torch.hypot(*state.base_position[:, :2].T) > _CROSSED)
            self.physics.terrain.grade(crossed.numpy(), fell.numpy())
        index = ended.nonzero().flatten()
        if len(index):
            self._reset(index)
            self.episode_length_buf[index] = 0
        return timed_out

    def _reset(self, index: torch.Tensor) -> None:
        """Start robots ``index`` (n,)."""
        count, rng, agent = len(index), self._rng, self.agent
        agent.set_velocity_command(index, self._draw_velocities(index))
        command = agent.command[index, :3]
        phase = rng.uniform(size=count) if agent.clock is not None else command.new_zeros(count)
        fraction = 0.0 if self._guide is None else self._train.reset.reference_fraction
        on_gait = rng.uniform(size=count) < fraction
        qpos, qvel = at_rest(self._robot, self._config.start, rng, count, command)
        velocity, heading = command.new_zeros(count, 2), qpos.new_full((count,), math.nan)
        if self._guide is not None:
            gait, when = command[on_gait], phase[on_gait]
            starts = sample_about(
                self._guide.states(gait, when), self._robot, self._config.start, rng
            )
            qpos[on_gait], qvel[on_gait] = starts
            heading[on_gait] = self._guide.course(gait, when)
            velocity[on_gait] = gait[:, :2]
        if agent.clock is not None and agent.clock.halts:
            phase[standing(command) & ~on_gait] = 0.0  # robots that stand from the start
        self._outputs[index] = math.inf
        self.physics.reset(index, qpos, qvel)
        self._read()
        heading = heading.where(on_gait, self._measured.yaw[index])
        agent.reset(index, self._measured, phase, velocity, heading)
        agent.refresh_heading(self._measured)

    def _draw_velocities(self, index: torch.Tensor) -> torch.Tensor:
        velocities = self._commands.sample(self._rng, len(index))
        return velocities if self._share is None else self._share[index, None] * velocities

    def _observe(self) -> None:
        values = self.agent.observe(self._measured)
        self._observations = TensorDict({"policy": values}, batch_size=[self.num_envs])
