"""``slider benchmark-training``: control steps per second of physics, environment and training.

All three do the same work: the states and inputs of the physics are recorded from the environment,
and its actions are as noisy as those of an untrained policy. Physics are those of the training's
``simulator``, on its ``device``.
"""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

import argparse
import contextlib
import io
import math
import os
import resource
import statistics
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slider.bench import replaced, timed
from slider.core.errors import UserError
from slider.library.choose import add_library_arguments, library_path

if TYPE_CHECKING:
    from slider.config.schema import Config
    from slider.env.task import Task

_RECORDED = 24  # control steps
_HEADER = (
    "           control steps per second, thousands            of bare physics\n"
    "  envs        bare physics      environment    whole loop      environment    loop"
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    envs = [256, 1024, 4096, 8192]
    parser.add_argument("overrides", nargs="*", help="such as train.walking.ppo.epochs=5")
    parser.add_argument("--conf", type=Path, default=Path("conf"), help="folder (default: conf)")
    parser.add_argument("--envs", type=int, nargs="+", default=envs, help=f"default: {envs}")
    parser.add_argument("--seconds", type=float, default=2.0, help="per measurement (default: 2)")
    parser.add_argument("--rounds", type=int, default=3, help="median of so many (default: 3)")
    parser.add_argument("--threads", type=int, help="default: resources.threads, else 1")
    parser.add_argument("--device", choices=("cpu", "cuda"), help="with MuJoCo Warp on it")
    add_library_arguments(parser)


def run(arguments: argparse.Namespace) -> None:
    """Print a row per number of environments, then the shares of the parts."""
    _check(arguments)
    from slider.artefacts.runner import limit_threads
    from slider.config.compose import compose
    from slider.core.machine import device, machine
    from slider.env.terms import checked

    overrides = list(arguments.overrides)
    if arguments.device:
        key = "train.walking"
        overrides += [f"{key}.simulator=mujoco_warp", f"{key}.device={arguments.device}"]
    config = checked(compose(overrides, arguments.conf))
    on_processor = device(config.train.walking.device) == "cpu"
    library = library_path(arguments)
    threads = arguments.threads or config.resources.threads or 1
    limit_threads(threads)  # before torch, as for a job of the pipeline
    print(f"{machine()}; {threads} threads, load {os.getloadavg()[0]:.1f} before the start")
    print(_HEADER, flush=True)
    rows = []
    for num_envs in arguments.envs:
        row = measure(config, library, threads, num_envs, arguments.seconds, arguments.rounds)
        rows.append(row)
        print(row.line(), flush=True)
    if on_processor:  # on a GPU the host's time is that of launches
        print("\nshares of the processor time of the training")
        for row in rows:
            parts = sorted(row.parts.items(), key=lambda item: -item[1])
            shares = ", ".join(f"{name} {100 * share:.1f} %" for name, share in parts)
            print(f"{row.num_envs:6d}  {shares}")
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    print(f"\nlargest memory {peak:.2f} GiB, load {os.getloadavg()[0]:.1f} at the end")


def _check(arguments: argparse.Namespace) -> None:
    threads = 1 if arguments.threads is None else arguments.threads
    limits = {"envs": min(arguments.envs), "rounds": arguments.rounds, "threads": threads}
    for name, value in limits.items():
        if value < 1:
            raise UserError(f"--{name}: expected at least 1, found {value}")
    if not 0 < arguments.seconds < math.inf:
        raise UserError(f"--seconds: expected a positive number, found {arguments.seconds}")


@dataclass(frozen=True)
class Rate:
    """Control steps of one robot, per second of time and per second of processor time."""

    wall: float
    cpu: float

    def __str__(self) -> str:
        return f"{self.wall / 1e3:7.1f} ({self.cpu / 1e3:5.1f})"


@dataclass(frozen=True)
class Throughput:
    """Medians over rounds for one number of environments.

    Attributes:
        bare: ``mujoco.rollout`` or MuJoCo Warp alone.
        environment: the environment's ``step``.
        loop: training iterations, everything included.
        parts: share of the training's processor time by part.
        clock: ``cpu``, or ``wall`` on a GPU, of the shares of the bare rate.
    """

    num_envs: int
    bare: Rate
    environment: Rate
    loop: Rate
    parts: dict[str, float]
    clock: str

    def line(self) -> str:
        """One row of the table: steps per second, in brackets per second of processor time."""
        bare = getattr(self.bare, self.clock)
        environment, loop = (getattr(r, self.clock) / bare for r in (self.environment, self.loop))
        rates = f"{self.bare}  {self.environment}  {self.loop}"
        return f"{self.num_envs:6d}  {rates}  {environment:9.0%}  {loop:9.0%}"


def measure(
    config: "Config",
    library: Path,
    threads: int,
    num_envs: int,
    seconds: float,
    rounds: int,
) -> Throughput:
    """Measure the walking training with ``num_envs`` robots."""
    from slider.core.machine import device, precision
    from slider.env.task import task_of

    walking = config.train.walking
    where = device(walking.device)
    ppo = replace(walking.ppo, precision=precision(walking.ppo.precision, where))
    train = replace(walking, robots=num_envs, device=where, ppo=ppo)
    task = task_of(config.robot, config.env, train, library)
    with tempfile.TemporaryDirectory() as work:
        return Bench(task, threads, Path(work)).measure(seconds, rounds)


class Bench:
    """Physics, environment and training of one task, each to be run for a while.

    Attributes:
        env: the environment.
        recorded: control steps that the bare physics repeats: states (N, 38) and motor angles
            (N, 10) of MuJoCo, or positions, velocities and inputs of MuJoCo Warp.
    """

    def __init__(self, task: "Task", threads: int, work: Path) -> None:
        import torch

        from slider.env.vec_env import WalkingEnv
        from slider.robot.names import NUM_JOINTS
        from slider.training.distributed import device_of
        from slider.training.stage import simulator
        from slider.training.trainer import set_up_torch

        set_up_torch()
        torch.manual_seed(task.train.seed)
        self._task, self._threads, self._work = task, threads, work
        self._device = device_of(task.train.device)
        shape = _RECORDED, task.train.robots, NUM_JOINTS
        noise = task.train.network.initial_std * torch.randn(shape)
        self._actions = noise.to(self._device)
        self.recorded: list[Any] = []
        self.env = WalkingEnv(task, threads, simulator(task.train))
        with_warp = task.train.simulator == "mujoco_warp"
        self.bare = self._bare_warp() if with_warp else self._bare_mujoco()

    def _bare_warp(self) -> Callable[[], int]:
        simulation = self.env.physics.simulation
        step, arrays = simulation.step, (simulation.qpos, simulation.qvel, simulation.control)

        def record() -> None:
            self.recorded.append([array.clone() for array in arrays])
            step()

        with replaced(simulation, "step", record):
            self._step()

        def repeat() -> int:
            for recorded in self.recorded:
                for array, values in zip(arrays, recorded, strict=True):
                    array.copy_(values)
                simulation.step()
            simulation.check()  # waits for the device
            return len(self.recorded) * len(simulation.qpos)

        return repeat

    def _bare_mujoco(self) -> Callable[[], int]:
        import mujoco
        import numpy as np
        from mujoco import rollout

        from slider.robot.transmission import Transmission

        physics, motors = self.env.physics, Transmission.of(self._task.robot)
        step, model, substeps = physics.step, physics.model, self._task.env.physics.substeps

        def record(inputs: Any) -> None:
            self.recorded.append((physics.state.copy(), motors.angles(np.asarray(inputs))))
            step(inputs)

        with replaced(physics, "step", record):
            self._step()
        pool = rollout.Rollout(nthread=self._threads)
        data = [mujoco.MjData(model) for _ in range(self._threads)]

        def repeat() -> int:
            for state, angles in self.recorded:
                pool.rollout(model, data, state, np.repeat(angles[:, None], substeps, axis=1))
            return len(self.recorded) * len(self._actions[0])

        return repeat

    def measure(self, seconds: float, rounds: int) -> Throughput:
        """Measure all three by turns, ``rounds`` times, at least ``seconds`` [s] each."""
        spent: dict[str, float] = defaultdict(float)
        work = self.bare, self._step, self._learn(spent)
        for once in work:  # first calls allocate
            once()
        spent.clear()
        rounds_of_rates = [[_rate(once, seconds) for once in work] for _ in range(rounds)]
        bare, environment, loop = map(_median, zip(*rounds_of_rates, strict=True))
        total = sum(spent.values())
        parts = {name: part / total for name, part in spent.items()}
        clock = "cpu" if self._device == "cpu" else "wall"
        return Throughput(self._task.train.robots, bare, environment, loop, parts, clock)

    def _step(self) -> int:
        import torch

        with torch.inference_mode():
            for actions in self._actions:
                rewards = self.env.step(actions)[1]
            float(rewards.sum())  # waits for the device
        return len(self._actions) * len(self._actions[0])

    def _learn(self, spent: dict[str, float]) -> Callable[[], int]:
        from rsl_rl.runners import OnPolicyRunner

        from slider.core.job import NoTracker
        from slider.training.ppo import runner_config

        train = self._task.train
        config = runner_config(train, NoTracker(), [])
        with contextlib.redirect_stdout(io.StringIO()):
            runner = OnPolicyRunner(self.env, config, log_dir=str(self._work), device=self._device)
        runner.save = lambda *_, **__: None  # a training saves once in many iterations
        methods = self.env.methods | {
            "policy": (runner.alg, "act"),
            "storage": (runner.alg, "process_env_step"),
            "returns": (runner.alg, "compute_returns"),
            "update": (runner.alg, "update"),
            "other": (runner, "learn"),
        }

        def learn() -> int:
            with contextlib.redirect_stdout(io.StringIO()), timed(methods, spent):
                runner.learn(1)
            return train.robots * train.steps_per_iteration

        return learn


def _rate(once: Callable[[], int], seconds: float) -> Rate:
    """Call ``once``, which returns the control steps done, for at least ``seconds`` [s]."""
    wall, cpu, steps = time.perf_counter(), time.process_time(), 0
    while time.perf_counter() - wall < seconds:
        steps += once()
    return Rate(steps / (time.perf_counter() - wall), steps / (time.process_time() - cpu))


def _median(rates: Sequence[Rate]) -> Rate:
    return Rate(*(statistics.median(getattr(r, clock) for r in rates) for clock in ("wall", "cpu")))
