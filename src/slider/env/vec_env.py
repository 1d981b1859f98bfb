"""The training environment: batched physics behind rsl-rl's ``VecEnv`` contract."""

from collections.abc import Callable
from dataclasses import replace
from functools import reduce
from operator import or_
from typing import Any

import numpy as np
import torch
from rsl_rl.env import VecEnv
from tensordict import TensorDict

from slider.core.arrays import Array, everyone, namespace, put, rows, which, zeros
from slider.env import terminations
from slider.env.commands import CommandSampler, Curriculum
from slider.env.declaration import Needs
from slider.env.disturbance.draws import Disturbance
from slider.env.interface import AgentInterface
from slider.env.phase import standing
from slider.env.rewards import Reward, RewardView
from slider.env.starts import about, at_rest
from slider.env.state import RobotState
from slider.env.task import Task
from slider.env.tensors import from_torch, generator, to_torch
from slider.env.underlying import build_physics
from slider.robot.names import ACTUATED, NUM_JOINTS


class WalkingEnv(VecEnv):
    """N robots with commanded velocities; a fall ends an episode, and so does its length.

    Observations: TensorDict with ``policy`` (N, size) float32. Actions: (N, 12).
    ``extras``: ``time_outs`` (N,) and ``log`` with the mean of every reward term.
    Commands, starts and phases follow from the training's seed.

    All arrays are of the library of the physics' positions. Where these are tensors, all is
    computed on their device, and nothing waits for it.

    Attributes:
        physics: the simulated robots.
        agent: their observations, actions, clock and commands.
        curriculum: share of the command ranges in use.
    """

    def __init__(
        self, task: Task, threads: int = 1, simulate: Callable[..., Any] = build_physics
    ) -> None:
        robot, config, train = task.robot, task.env, task.train
        terminations.check(config.termination.terms)
        self.num_envs = train.robots
        self.num_actions = NUM_JOINTS
        self.max_episode_length = round(train.episode_length / config.control_period)
        self.cfg: dict | object = config
        self._robot, self._config, self._train = robot, config, train
        self.physics = simulate(
            robot,
            config.physics,
            self.num_envs,
            threads,
            disturbance=Disturbance(train.disturbance, (train.seed,)),
            underlying=task.underlying,
            instruments=False,
        )
        like = self._like = self.physics.qpos[:0]
        self.device = like.device
        self.episode_length_buf = torch.zeros(self.num_envs, dtype=torch.long, device=self.device)
        self._diverged = zeros(1, like)
        self._rng = generator(train.seed, like)
        self._guide = None if task.guide is None else task.guide.beside(like)
        self.agent = AgentInterface(
            robot, config, self.num_envs, task.times, task.reference, task.underlying, like
        )
        self._commands = CommandSampler(train.commands, config.control_period, like)
        self.curriculum = Curriculum(train.commands.curriculum, self.num_envs, like)
        self._reward = Reward(train.reward)
        self._outputs = zeros((self.num_envs, 2, len(ACTUATED)), like) + np.inf
        self._measured = self._reset(everyone(self.num_envs, like))
        self._observe()

    @property
    def total_diverged(self) -> int:
        """Simulations that blew up so far."""
        return int(self._diverged.item())

    def check(self) -> None:
        """Look for errors of the simulation so far; this may wait for a device.

        Raises:
            UserError: names the robots.
        """
        self.physics.check()

    @property
    def methods(self) -> dict[str, tuple[object, str]]:
        """Owner and name of the methods that make up a step, by what they do."""
        return {
            "physics": (self.physics, "step"),
            "state": (self.physics, "read"),
            "observation": (self.agent, "observe"),
            "reward": (self, "_reward"),
            "environment": (self, "step"),
        }

    def get_observations(self) -> TensorDict:
        """Current observations."""
        return self._observations

    def step(self, actions: torch.Tensor) -> tuple[TensorDict, torch.Tensor, torch.Tensor, dict]:
        """One control period for all robots."""
        state = self._simulate(self.agent.act(from_torch(actions, self._like)))
        self.agent.advance(self._measured)
        fell = terminations.failed(state, self._config.termination.terms)
        view = self.agent.view(state)
        seen = RewardView(view, self._guide, self._outputs)
        reward, parts = self._reward(seen, fell)
        if Needs.PAST in self._reward.needs:
            self._outputs = namespace(reward).asarray(seen.outputs, copy=True)
        speed_error = abs(view.filtered_velocity[:, 0] - view.command[:, 0])
        self._diverged += state.diverged.sum()
        timed_out = self._end_episodes(fell)
        self._change_commands()
        self._observe()
        extras = {
            "time_outs": to_torch(timed_out, torch.float32),
            "log": self._log(parts, speed_error, fell, state.diverged),
        }
        done = to_torch(fell | timed_out, torch.int64)
        return self._observations, to_torch(reward, torch.float32), done, extras

    def _simulate(self, acted: Array) -> RobotState:
        """The state after a control period, in which a simulation may have diverged at any tick."""
        states = [self._tick(acted) for _ in range(self.agent.ticks)]
        return replace(states[-1], diverged=reduce(or_, [state.diverged for state in states]))

    def _tick(self, acted: Array) -> RobotState:
        self.physics.step(self.agent.inputs(acted, self._measured))
        state = self.physics.read()
        self._measured = self.physics.measure(state)
        return state

    def _end_episodes(self, fell: Array) -> Array:
        """Robots (N,) whose time is over and that did not fall; all that ended start anew."""
        self.episode_length_buf += 1
        old = self.episode_length_buf >= self.max_episode_length
        timed_out = from_torch(old, self._like) & ~fell
        ended = fell | timed_out
        index = which(ended)
        if len(index):  # with tensors always, so that nobody has to look
            self.curriculum.note(ended, fell)
            self._measured = self._reset(index)
            self.episode_length_buf.masked_fill_(to_torch(ended, torch.bool), 0)
        return timed_out

    def _log(
        self, parts: dict[str, Array], speed_error: Array, fell: Array, diverged: Array
    ) -> dict[str, Any]:
        log = {f"/reward/{name}": values.mean() for name, values in parts.items()}
        log["/episode/falls_per_second"] = (1.0 * fell).mean() / self._config.control_period
        log["/episode/speed_error"] = speed_error.mean()
        log["/episode/diverged"] = (1.0 * diverged).sum()
        if self.curriculum.enabled:
            log["/episode/command_share"] = self.curriculum.share.mean()
        return log

    def _reset(self, index: Array) -> RobotState:
        """Start robots ``index`` anew; what is measured of all robots afterwards."""
        count, rng, agent = len(index), self._rng, self.agent
        agent.set_velocity_command(index, self._draw_commands(count))
        command = rows(agent.command, index)[:, :3]
        phase = rng.uniform(size=count) if agent.clock is not None else zeros(count, command)
        if agent.controller is not None:
            phase = np.floor(2.0 * phase) / 2.0  # its walks begin with a step
        on_gait = self._choose_reference_starts(count)
        qpos, qvel = at_rest(self._robot, self._config.start, rng, count, command)
        velocity, course = zeros((count, 2), command), zeros(count, command)
        some, xp = which(on_gait), namespace(command)
        if self._guide is not None and len(some):
            going, when = rows(command, some), rows(phase, some)
            starts = about(self._guide.states(going, when), self._robot, self._config.start, rng)
            put(qpos, some, starts[0])
            put(qvel, some, starts[1])
            put(course, some, self._guide.course(going, when))
            put(velocity, some, going[:, :2])
        if agent.clock is not None and agent.clock.halts:
            resting = standing(command) & ~on_gait
            phase = xp.where(resting, 0.0, phase)  # they stand from the start
        put(self._outputs, index, np.inf)
        self.physics.reset(index, qpos, qvel)
        state = self.physics.measure(self.physics.read())
        heading = xp.where(on_gait, course, rows(state.yaw, index))
        agent.reset(index, state, phase, velocity, heading, on_gait)
        agent.refresh_heading(state)
        return state

    def _choose_reference_starts(self, count: int) -> Array:
        draw = self._rng.uniform(size=count)
        return draw < (0.0 if self._guide is None else self._train.reset.reference_fraction)

    def _change_commands(self) -> None:
        index = self._commands.changing(self._rng, self.num_envs)
        if len(index):
            self.agent.set_velocity_command(index, self._draw_commands(len(index)))

    def _draw_commands(self, count: int) -> Array:
        return self._commands.sample(self._rng, count, self.curriculum.share)

    def _observe(self) -> None:
        values = to_torch(self.agent.observe(self._measured), torch.float32)
        self._observations = TensorDict({"policy": values}, batch_size=[self.num_envs])
