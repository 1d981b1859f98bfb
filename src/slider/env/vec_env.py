"""The training environment: batched physics behind rsl-rl's ``VecEnv`` contract."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import torch
from rsl_rl.env import VecEnv
from tensordict import TensorDict

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
from slider.env.underlying import build_physics
from slider.robot.names import ACTUATED, NUM_JOINTS


@dataclass(frozen=True)
class Episodes:
    """What ended in a control step."""

    fell: np.ndarray
    timed_out: np.ndarray
    diverged: int


class WalkingEnv(VecEnv):
    """N robots with commanded velocities; a fall ends an episode, and so does its length.

    Observations: TensorDict with ``policy`` (N, size) float32. Actions: (N, 12).
    ``extras``: ``time_outs`` (N,) and ``log`` with the mean of every reward term.
    Commands, starts and phases follow from the training's seed.

    Attributes:
        physics: the simulated robots.
        agent: their observations, actions, clock and commands.
        curriculum: share of the command ranges in use.
        total_diverged: simulations that blew up so far.
    """

    def __init__(
        self, task: Task, threads: int = 1, simulate: Callable[..., Any] = build_physics
    ) -> None:
        robot, config, train = task.robot, task.env, task.train
        terminations.check(config.termination.terms)
        self.num_envs = train.robots
        self.num_actions = NUM_JOINTS
        self.max_episode_length = round(train.episode_length / config.control_period)
        self.episode_length_buf = torch.zeros(self.num_envs, dtype=torch.long)
        self.device = "cpu"
        self.cfg: dict | object = config
        self.total_diverged = 0
        self._robot, self._config, self._train = robot, config, train
        self._rng = np.random.default_rng(train.seed)
        self._guide = task.guide
        self.physics = simulate(
            robot,
            config.physics,
            self.num_envs,
            threads,
            disturbance=Disturbance(train.disturbance, (train.seed,)),
            underlying=task.underlying,
            instruments=False,
        )
        self.agent = AgentInterface(
            robot, config, self.num_envs, task.times, task.reference, task.underlying
        )
        self._commands = CommandSampler(train.commands, config.control_period)
        self.curriculum = Curriculum(train.commands.curriculum, self.num_envs)
        self._reward = Reward(train.reward)
        self._outputs = np.full((self.num_envs, 2, len(ACTUATED)), np.inf)
        self._measured = self._reset(np.arange(self.num_envs))
        self._observe()

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
        state = self._simulate(self.agent.act(actions.numpy().astype(np.float64)))
        self.agent.advance(self._measured)
        fell = terminations.failed(state, self._config.termination.terms)
        view = self.agent.view(state)
        seen = RewardView(view, self._guide, self._outputs)
        reward, parts = self._reward(seen, fell)
        if Needs.PAST in self._reward.needs:
            self._outputs = seen.outputs.copy()
        speed_error = np.abs(view.filtered_velocity[:, 0] - view.command[:, 0])
        episodes = self._end_episodes(fell, int(state.diverged.sum()))
        self._change_commands()
        self._observe()
        extras = {
            "time_outs": torch.from_numpy(episodes.timed_out.astype(np.float32)),
            "log": self._log(parts, speed_error, episodes),
        }
        done = torch.from_numpy((episodes.fell | episodes.timed_out).astype(np.int64))
        return self._observations, torch.from_numpy(reward.astype(np.float32)), done, extras

    def _simulate(self, acted: np.ndarray) -> RobotState:
        """The state after a control period, in which a simulation may have diverged at any tick."""
        states = [self._tick(acted) for _ in range(self.agent.ticks)]
        return replace(states[-1], diverged=np.any([s.diverged for s in states], axis=0))

    def _tick(self, acted: np.ndarray) -> RobotState:
        self.physics.step(self.agent.inputs(acted, self._measured))
        state = self.physics.read()
        self._measured = self.physics.measure(state)
        return state

    def _end_episodes(self, fell: np.ndarray, diverged: int) -> Episodes:
        self.total_diverged += diverged
        self.episode_length_buf += 1
        timed_out = (self.episode_length_buf >= self.max_episode_length).numpy() & ~fell
        ended = np.flatnonzero(fell | timed_out)
        if len(ended):
            self.curriculum.note(len(ended), int(fell.sum()))
            self._measured = self._reset(ended)
            self.episode_length_buf[torch.from_numpy(ended)] = 0
        return Episodes(fell, timed_out, diverged)

    def _log(
        self, parts: dict[str, np.ndarray], speed_error: np.ndarray, episodes: Episodes
    ) -> dict[str, float]:
        log = {f"/reward/{name}": float(values.mean()) for name, values in parts.items()}
        log["/episode/falls_per_second"] = float(episodes.fell.mean()) / self._config.control_period
        log["/episode/speed_error"] = float(speed_error.mean())
        log["/episode/diverged"] = float(episodes.diverged)
        if self.curriculum.enabled:
            log["/episode/command_share"] = self.curriculum.share
        return log

    def _reset(self, index: np.ndarray) -> RobotState:
        """Start robots ``index`` anew; what is measured of all robots afterwards."""
        count, rng = len(index), self._rng
        self.agent.set_velocity_command(index, self._draw_commands(count))
        phase = rng.uniform(size=count) if self.agent.clock is not None else np.zeros(count)
        if self.agent.controller is not None:
            phase = np.floor(2.0 * phase) / 2.0  # its walks begin with a step
        on_gait = self._choose_reference_starts(count)
        qpos, qvel = at_rest(self._robot, self._config.start, rng, count)
        velocity, course = np.zeros((count, 2)), np.zeros(count)
        if on_gait.any():
            command = self.agent.command[index[on_gait], :3]
            states, course[on_gait] = self._on_reference(command, phase[on_gait])
            qpos[on_gait], qvel[on_gait] = states
            velocity[on_gait] = command[:, :2]
        if self.agent.clock is not None and self.agent.clock.halts:
            resting = standing(self.agent.command[index]) & ~on_gait
            phase = np.where(resting, 0.0, phase)  # they stand from the start
        self._outputs[index] = np.inf
        self.physics.reset(index, qpos, qvel)
        state = self.physics.measure(self.physics.read())
        heading = np.where(on_gait, course, state.yaw[index])
        self.agent.reset(index, state, phase, velocity, heading, on_gait)
        self.agent.refresh_heading(state)
        return state

    def _choose_reference_starts(self, count: int) -> np.ndarray:
        draw = self._rng.uniform(size=count)
        if self._guide is None:
            return np.zeros(count, dtype=bool)
        return draw < self._train.reset.reference_fraction

    def _on_reference(
        self, command: np.ndarray, phase: np.ndarray
    ) -> tuple[tuple[np.ndarray, np.ndarray], np.ndarray]:
        """Positions and velocities on the gaits of commands (n, 3), with noise; their courses."""
        assert self._guide is not None
        states = about(
            self._guide.states(command, phase), self._robot, self._config.start, self._rng
        )
        return states, self._guide.course(command, phase)

    def _change_commands(self) -> None:
        index = self._commands.changing(self._rng, self.num_envs)
        if len(index):
            self.agent.set_velocity_command(index, self._draw_commands(len(index)))

    def _draw_commands(self, count: int) -> np.ndarray:
        return self._commands.sample(self._rng, count, self.curriculum.share)

    def _observe(self) -> None:
        values = torch.from_numpy(self.agent.observe(self._measured))
        self._observations = TensorDict({"policy": values}, batch_size=[self.num_envs])
