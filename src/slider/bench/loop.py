"""``slider benchmark-training``: control steps per second of environment and training.

Actions of the environment are as noisy as those of an untrained policy. The share of the physics
bounds what the other parts can gain. Physics are those of the training's ``simulator``, on its
``device``.
"""

import argparse
import contextlib
import io
import math
import os
import resource
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from slider.bench import timed
from slider.core.errors import require
from slider.library.choose import add_library_arguments, library_path

if TYPE_CHECKING:
    from slider.config.train import TrainConfig
    from slider.env.vec_env import Task, WalkingEnv

_STEPS = 24  # control steps of the environment between two looks at the clock
_HEADER = "control steps per second, thousands\n  envs      environment       whole loop"


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
    threads = 1 if arguments.threads is None else arguments.threads
    limits = {"envs": min(arguments.envs), "rounds": arguments.rounds, "threads": threads}
    for name, value in limits.items():
        require(value >= 1, f"--{name}", "at least 1", value)
    seconds = arguments.seconds
    require(0 < seconds < math.inf, "--seconds", "a positive number", seconds)
    from slider.artefacts.runner import limit_threads
    from slider.config.compose import compose
    from slider.core.machine import device, machine, precision
    from slider.env.terms import checked

    overrides = list(arguments.overrides)
    if arguments.device:
        key = "train.walking"
        overrides += [f"{key}.simulator=mujoco_warp", f"{key}.device={arguments.device}"]
    config = checked(compose(overrides, arguments.conf))
    walking = config.train.walking
    where = device(walking.device)
    ppo = replace(walking.ppo, precision=precision(walking.ppo.precision, where))
    walking = replace(walking, device=where, ppo=ppo)
    library = library_path(arguments)
    threads = arguments.threads or config.resources.threads or 1
    limit_threads(threads)  # before torch, as for a job of the pipeline
    from slider.env.vec_env import task_of

    print(f"{machine()}; {threads} threads, load {os.getloadavg()[0]:.1f} before the start")
    print(_HEADER, flush=True)
    shares = {}
    for robots in arguments.envs:
        task = task_of(config.robot, config.env, replace(walking, robots=robots), library)
        rates, shares[robots] = measure(task, threads, seconds, arguments.rounds)
        texts = (f"{wall / 1e3:7.1f} ({cpu / 1e3:5.1f})" for wall, cpu in rates.tolist())
        print(f"{robots:6d}  {'  '.join(texts)}", flush=True)
    if where == "cpu":  # on a GPU the host's time is that of launches
        print("\nshares of the processor time of the training")
        for robots, parts in shares.items():
            ordered = sorted(parts.items(), key=lambda item: -item[1])
            texts = (f"{name} {100 * share:.1f} %" for name, share in ordered)
            print(f"{robots:6d}  {', '.join(texts)}")
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    print(f"\nlargest memory {peak:.2f} GiB, load {os.getloadavg()[0]:.1f} at the end")


def measure(
    task: "Task", threads: int, seconds: float, rounds: int
) -> tuple[np.ndarray, dict[str, float]]:
    """Measure environment and training by turns, ``rounds`` times, ``seconds`` [s] each.

    Returns:
        Medians (2, 2) of the control steps per second: of the environment and of training
        iterations, everything included; per second of wall and of processor time. And the share of
        the training's processor time by part.
    """
    import torch

    from slider.env.vec_env import WalkingEnv
    from slider.training.stage import simulator
    from slider.training.trainer import set_up_torch

    set_up_torch()
    torch.manual_seed(task.train.seed)
    env = WalkingEnv(task, threads, simulator(task.train))
    spent: dict[str, float] = defaultdict(float)
    with tempfile.TemporaryDirectory() as folder:
        work = _stepping(env, task.train), _learning(env, task.train, folder, spent)
        for once in work:  # first calls allocate
            once()
        spent.clear()
        rates = [[_rate(once, seconds) for once in work] for _ in range(rounds)]
    total = sum(spent.values())
    return np.median(rates, axis=0), {name: part / total for name, part in spent.items()}


def _stepping(env: "WalkingEnv", train: "TrainConfig") -> Callable[[], int]:
    """Function that steps the environment and returns the control steps done."""
    import torch

    shape = _STEPS, train.robots, env.num_actions
    actions = (train.network.initial_std * torch.randn(shape)).to(env.device)

    def step() -> int:
        with torch.inference_mode():
            for now in actions:
                rewards = env.step(now)[1]
            float(rewards.sum())  # waits for the device
        return _STEPS * train.robots

    return step


def _learning(
    env: "WalkingEnv", train: "TrainConfig", folder: str, spent: dict[str, float]
) -> Callable[[], int]:
    """Function that trains for an iteration, adds to ``spent``, and returns the control steps."""
    from rsl_rl.runners import OnPolicyRunner

    from slider.core.job import NoTracker
    from slider.training.ppo import runner_config

    config = runner_config(train, NoTracker(), [])
    with contextlib.redirect_stdout(io.StringIO()):
        runner = OnPolicyRunner(env, config, log_dir=folder, device=train.device)
    runner.save = lambda *_, **__: None  # a training saves once in many iterations
    methods = {
        "physics": (env.physics, "step"),
        "state": (env.physics, "read"),
        "observation": (env.agent, "observe"),
        "reward": (env, "reward"),
        "environment": (env, "step"),
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


def _rate(once: Callable[[], int], seconds: float) -> tuple[float, float]:
    """Call ``once``, which returns the control steps done, for at least ``seconds`` [s].

    Returns:
        Steps per second of wall and of processor time.
    """
    wall, cpu, steps = time.perf_counter(), time.process_time(), 0
    while time.perf_counter() - wall < seconds:
        steps += once()
    return steps / (time.perf_counter() - wall), steps / (time.process_time() - cpu)
