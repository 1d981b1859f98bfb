"""How many control steps per second: bare physics, the environment, the whole training.

All three do the same work: the physics' states and inputs are recorded from the environment, and
the environment gets actions as noisy as an untrained policy's. Physics are those of the training's
``simulator``, on its ``device``.
"""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

import contextlib
import io
import statistics
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import torch
from mujoco import rollout
from rsl_rl.runners import OnPolicyRunner

from slider.bench.products import products
from slider.bench.stopwatch import Stopwatch
from slider.config.schema import Config
from slider.core.job import NoTracker
from slider.env.task import Task, task_of
from slider.env.vec_env import WalkingEnv
from slider.robot.names import NUM_JOINTS
from slider.robot.transmission import Transmission
from slider.training.beside import set_up_thread
from slider.training.distributed import device_of
from slider.training.ppo import runner_config

_RECORDED = 24  # control steps
_PRODUCTS = "products "


@dataclass(frozen=True)
class Rate:
    """Control steps of one robot, per second of time and per second of processor time."""

    wall: float
    cpu: float


@dataclass(frozen=True)
class Throughput:
    """Medians over rounds for one number of environments and one precision of the update.

    Attributes:
        bare: ``mujoco.rollout`` or MuJoCo Warp alone.
        environment: the environment's ``step``.
        loop: training iterations, everything included.
        environment_share, loop_share: of the bare rate, in processor time; on a GPU in time.
        products_share: share of the training's processor time that the matrix products of its
            update take alone; on a GPU of its time.
        parts: share of the training's processor time by part.
    """

    num_envs: int
    precision: str
    bare: Rate
    environment: Rate
    loop: Rate
    environment_share: float
    loop_share: float
    products_share: float
    parts: dict[str, float]


def measure(
    config: Config,
    library: Path,
    threads: int,
    num_envs: int,
    precisions: Sequence[str],
    seconds: float,
    rounds: int,
) -> list[Throughput]:
    """Measure the walking training with ``num_envs`` robots, once for each precision."""
    train = replace(config.train.walking, robots=num_envs)
    task = task_of(config.robot, config.env, train, library)
    with tempfile.TemporaryDirectory() as work:
        return Bench(task, threads, Path(work)).measure(precisions, seconds, rounds)


class Bench:
    """Physics, environment and training of one task, each to be run for a while.

    Attributes:
        env: the environment.
        recorded: control steps that the bare physics repeats: states (N, 38) and motor angles
            (N, 10) of MuJoCo, or those of :mod:`slider.bench.warp`.
    """

    def __init__(self, task: Task, threads: int, work: Path) -> None:
        set_up_thread()
        torch.manual_seed(task.train.seed)
        self._task, self._threads, self._work = task, threads, work
        self._device = device_of(task.train.device)
        with_warp = task.train.simulator == "mujoco_warp"
        self.env = self._warp_env(threads) if with_warp else WalkingEnv(task, threads)
        self._physics = self.env.physics
        self._actions = task.train.network.initial_std * torch.randn(
            _RECORDED, task.train.robots, NUM_JOINTS
        ).to(self._device)
        self.recorded: list[Any] = []
        self._bare = self._bare_warp() if with_warp else self._bare_rollout(threads)

    def _warp_env(self, threads: int) -> WalkingEnv:
        from slider.training.warp import build_physics

        return WalkingEnv(self._task, threads, partial(build_physics, self._task.train.device))

    def _bare_warp(self) -> Callable[[], int]:
        from slider.bench.warp import BareWarp, record

        self.recorded = record(self._physics.simulation, self._step)
        return BareWarp(self._task, self.recorded)

    def _bare_rollout(self, threads: int) -> Callable[[], int]:
        self.recorded, pool = self._record(), rollout.Rollout(nthread=threads)
        model, substeps = self._physics.model, self._task.env.physics.substeps
        data = [mujoco.MjData(model) for _ in range(threads)]

        def roll_out() -> int:
            for state, angles in self.recorded:
                pool.rollout(model, data, state, np.repeat(angles[:, None], substeps, axis=1))
            return len(self.recorded) * len(self._actions[0])

        return roll_out

    def measure(self, precisions: Sequence[str], seconds: float, rounds: int) -> list[Throughput]:
        """Measure all by turns, ``rounds`` times, at least ``seconds`` [s] each."""
        runners = {name: self._runner(name) for name in precisions}
        watches = {name: Stopwatch() for name in precisions}
        work: dict[str, Callable[[], int]] = {"bare": self._bare, "environment": self._step}
        work |= {name: self._learn(runner, watches[name]) for name, runner in runners.items()}
        work |= {_PRODUCTS + name: self._multiply(r, name) for name, r in runners.items()}
        for once in work.values():  # first calls allocate
            once()
        for watch in watches.values():
            watch.seconds.clear()
        rates = {name: [] for name in work}
        for _ in range(rounds):
            for name, once in work.items():
                rates[name].append(_run(once, seconds))
        return [self._summary(name, rates, watches[name]) for name in precisions]

    def _summary(
        self, precision: str, rates: dict[str, list[Rate]], watch: Stopwatch
    ) -> Throughput:
        names = ("bare", "environment", precision, _PRODUCTS + precision)
        bare, environment, loop, multiplied = (rates[name] for name in names)
        total = sum(watch.seconds.values())
        return Throughput(
            num_envs=self._task.train.robots,
            precision=precision,
            bare=_median(bare),
            environment=_median(environment),
            loop=_median(loop),
            environment_share=self._share(environment, bare),
            loop_share=self._share(loop, bare),
            products_share=self._share(loop, multiplied),
            parts={name: seconds / total for name, seconds in watch.seconds.items()},
        )

    def _share(self, part: list[Rate], whole: list[Rate]) -> float:
        """Median over rounds: what slows one round down slows all its measurements down."""
        clock = "cpu" if self._device == "cpu" else "wall"
        pairs = zip(part, whole, strict=True)
        return statistics.median(getattr(p, clock) / getattr(w, clock) for p, w in pairs)

    def _record(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """States and inputs of the motors in some steps of the environment."""
        recorded = []
        real, motors = self._physics.step, Transmission.of(self._task.robot)

        def step(inputs: np.ndarray) -> None:
            recorded.append((self._physics.state.copy(), motors.angles(inputs)))
            real(inputs)

        self._physics.step = step  # type: ignore[method-assign]
        self._step()
        del self._physics.step
        return recorded

    def _step(self) -> int:
        with torch.inference_mode():
            for actions in self._actions:
                rewards = self.env.step(actions)[1]
            float(rewards.sum())  # waits for the device
        return len(self._actions) * len(self._actions[0])

    def _runner(self, precision: str) -> OnPolicyRunner:
        train = self._task.train
        train = replace(train, ppo=replace(train.ppo, precision=precision))
        config = runner_config(train, NoTracker(), [], self._threads)
        with contextlib.redirect_stdout(io.StringIO()):
            runner = OnPolicyRunner(self.env, config, log_dir=str(self._work), device=self._device)
        runner.save = lambda *_, **__: None  # a training saves once in many iterations
        return runner

    def _multiply(self, runner: OnPolicyRunner, precision: str) -> Callable[[], int]:
        train = self._task.train
        steps = train.robots * train.steps_per_iteration
        batches = train.ppo.mini_batches
        networks, dtype = (runner.alg.actor, runner.alg.critic), getattr(torch, precision)
        update = products(networks, steps // batches, batches * train.ppo.epochs, dtype)

        def multiply() -> int:
            update()
            if self._device != "cpu":
                torch.cuda.synchronize()
            return steps

        return multiply

    def _learn(self, runner: OnPolicyRunner, watch: Stopwatch) -> Callable[[], int]:
        methods = self.env.methods | {
            "policy": (runner.alg, "act"),
            "storage": (runner.alg, "process_env_step"),
            "returns": (runner.alg, "compute_returns"),
            "update": (runner.alg, "update"),
            "other": (runner, "learn"),
        }

        def learn() -> int:
            with contextlib.redirect_stdout(io.StringIO()), watch.watching(methods):
                runner.learn(1)
            return self._task.train.robots * self._task.train.steps_per_iteration

        return learn


def _run(once: Callable[[], int], seconds: float) -> Rate:
    """Do it again and again for at least ``seconds`` [s]; it returns the control steps done."""
    wall, cpu, steps = time.perf_counter(), time.process_time(), 0
    while time.perf_counter() - wall < seconds:
        steps += once()
    return Rate(steps / (time.perf_counter() - wall), steps / (time.process_time() - cpu))


def _median(rates: list[Rate]) -> Rate:
    return Rate(
        statistics.median(rate.wall for rate in rates),
        statistics.median(rate.cpu for rate in rates),
    )
