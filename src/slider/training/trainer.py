"""The stages ``standing`` and ``walking``: train a policy with PPO in chunks, keep the best.

A check and a checkpoint follow each chunk. The next chunk starts from the checkpoint with new
robots, buffers and random numbers, in the same process or, if that was killed, in another one: the
result has the same bytes.
"""

import gc
import hashlib
import io
import os
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from importlib import import_module
from itertools import zip_longest
from pathlib import Path
from typing import Any, cast

import numpy as np
import pandas as pd
import torch
from rsl_rl.runners import OnPolicyRunner

from slider.config.convert import from_dict
from slider.config.env import EnvConfig
from slider.config.robot import RobotConfig
from slider.config.train import WARP, TrainConfig
from slider.control import POLICY_FILE
from slider.control.policy import (
    STD,
    UNVARIED,
    VARIANCE,
    Policy,
    from_actor,
    save,
    save_policy,
)
from slider.core.errors import not_read
from slider.core.job import Inputs, Job, Section, Summary
from slider.env.vec_env import Task, WalkingEnv, task_of
from slider.library.reader import STORE
from slider.training.ppo import NORMALISER_EPSILON, AnnealedPPO, runner_config
from slider.training.results import CURVE, SELECTION
from slider.training.selection import Score, Selector

WEIGHTS = "weights.pt"
CHECKPOINT, BEFORE = "checkpoint.pt", "checkpoint_before.pt"  # the last two, each with a digest


def run_standing(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Pre-train a policy that stands; it is not guided by the library."""
    return _run(section, inputs, out, job, guided=False)


def run_walking(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Train walking, from the weights of another training and with the library, where given."""
    return _run(section, inputs, out, job, guided=True)


def _run(section: Section, inputs: Inputs, out: Path, job: Job, guided: bool) -> Summary:
    """Train, from the weights of another training where given, and export the best policy."""
    robot, env = from_dict(RobotConfig, section["robot"]), from_dict(EnvConfig, section["env"])
    train = from_dict(TrainConfig, section["train"])
    library = inputs["library"][0] / STORE if "library" in inputs else None
    trainer = Trainer(task_of(robot, env, train, library, guided), job, simulator(train))
    if "start" in inputs:
        trainer.start_from(inputs["start"][0] / WEIGHTS)
    trainer.run()
    return trainer.export(out)


def simulator(train: TrainConfig) -> Callable[..., Any] | None:
    """Constructor of MuJoCo Warp's physics (extra ``gpu``), where a training asks for it.

    Raises:
        UserError: MuJoCo Warp is not installed.
    """
    if train.simulator == "mujoco":
        return None
    warp = import_module(WARP)  # Table 1 does not depend on it
    return partial(warp.WarpPhysics, device=train.device)


class Trainer:
    """One training run, which can resume after being killed.

    Attributes:
        env: the simulated robots.
        algorithm: PPO with actor, critic and average.
        selector: scores policies.
    """

    def __init__(self, task: Task, job: Job, simulate: Callable[..., Any] | None = None) -> None:
        set_up_torch()
        self._task, self._job, self._simulate = task, job, simulate
        job.work.mkdir(parents=True, exist_ok=True)
        self.selector = Selector(task, job.threads)
        self._begin(read_checkpoint(job.work, job.progress))

    def _begin(self, content: Mapping[str, Any]) -> None:
        """Begin a chunk from a checkpoint, or the first one; the seed determines the rest."""
        self._iteration, self._blow_ups = content.get("iteration", 0), content.get("blow_ups", 0)
        self._best: dict[str, Any] = content.get("best", {})
        self._history: list[dict[str, float]] = content.get("history", [])
        self._curve: list[dict[str, float]] = content.get("curve", [])
        train, job = self._task.train, self._job
        seed = _noise_seed(train.seed, self._iteration)
        torch.manual_seed(seed)
        own = replace(self._task, train=replace(train, seed=seed))
        self.env = WalkingEnv(own, job.threads, self._simulate)
        config = runner_config(train, job.log_metrics, self._curve)
        self._runner = OnPolicyRunner(self.env, config, log_dir=str(job.work), device=train.device)
        self._runner.current_learning_iteration = self._iteration
        self.algorithm = cast(AnnealedPPO, self._runner.alg)
        if content:
            loaded = ("actor", "critic", "optimizer", "average")
            self.algorithm.load(dict(content), dict.fromkeys(loaded, True), True)
            self.env.restore_levels(content["terrain_levels"])
            return
        with torch.no_grad():  # small first actions
            last = list(self.algorithm.get_policy().mlp.parameters())[-2]  # weight, then bias
            last.mul_(train.network.output_scale)

    def start_from(self, weights: Path) -> None:
        """Initialise actor, critic and normalisers; the action noise keeps its initial size.

        Observations that did not vary in the other training, such as the commands in one of
        standing, start with a standard deviation of 1. No effect when resuming from a checkpoint.
        """
        if self._iteration:
            return
        content = torch.load(weights, weights_only=True)
        own = self.algorithm.get_policy().state_dict()
        noise = {k: v for k, v in own.items() if k.startswith("distribution.")}
        content["actor_state_dict"] = {**content["actor_state_dict"], **noise}
        for name in ("actor_state_dict", "critic_state_dict"):
            content[name] = _with_unit_scales(content[name])
        self.algorithm.load(content, {"actor": True, "critic": True}, strict=True)

    def run(self) -> None:
        """Train up to the configured number of iterations."""
        started, done_before = time.monotonic(), self._iteration
        total = self._task.train.iterations
        while self._iteration < total:
            chunk = min(self._task.train.selection.interval, total - self._iteration)
            # a trained policy rarely falls: episodes of equal age would all end at once
            self._runner.learn(chunk, init_at_random_ep_len=self._iteration > 0)
            self._iteration += chunk
            self._blow_ups += int(self.env.diverged)
            self.env.physics.check()
            score = self._check()
            content = self._save_checkpoint()
            if self._iteration < total:
                self._begin(content)
            gc.collect()  # the last chunk's robots: reference cycles
            pace = (time.monotonic() - started) / (self._iteration - done_before)
            self._report(score, pace)
        if not self._best:
            self._check()
        self._job.metadata["blow_ups"] = self._blow_ups

    def _check(self) -> Score:
        """Score the current policy; remember it if it is the best so far."""
        actor = self.algorithm.averaged_actor.state_dict()
        score = self.selector.score(self._network(actor))
        numbers = score.numbers()
        self._history.append({"iteration": self._iteration, **numbers})
        if not self._best or score.value <= self._best["score"]["value"]:
            critic = self.algorithm.save()["critic_state_dict"]
            weights = {"actor_state_dict": _copy(actor), "critic_state_dict": _copy(critic)}
            self._best = {"score": numbers, "iteration": self._iteration, "weights": weights}
        metrics = {f"selection/{name}": value for name, value in numbers.items()}
        self._job.log_metrics(metrics, self._iteration)
        return score

    def _network(self, actor_state: Mapping[str, torch.Tensor]):
        network = self._task.train.network
        return from_actor(actor_state, network.hidden, network.activation, NORMALISER_EPSILON)

    def _report(self, score: Score, pace: float) -> None:
        train = self._task.train
        left = pace * (train.iterations - self._iteration)
        rate = train.robots * train.steps_per_iteration / pace
        error = f"speed error {score.speed_error:.3f} m/s, score {score.value:.3f}"
        self._job.progress(
            f"iteration {self._iteration}/{train.iterations}, {rate / 1e3:.1f} k steps/s, "
            f"{left / 60:.1f} min left, success {100 * score.success:.0f} %, "
            f"tracking {100 * score.tracked:.0f} %" + (f", {error}" if score.success > 0 else "")
        )

    def _save_checkpoint(self) -> dict[str, Any]:
        content = {
            **self.algorithm.save(),
            "iteration": self._iteration,
            "blow_ups": self._blow_ups,
            "best": self._best,
            "history": self._history,
            "curve": self._curve,
            "terrain_levels": self.env.terrain_levels,
        }
        write_checkpoint(content, self._job.work)
        for leftover in self._job.work.glob("model_*.pt"):  # rsl-rl saves at the end of each chunk
            leftover.unlink()
        return content

    def export(self, out: Path) -> dict[str, Any]:
        """Write the best policy and its weights; return a summary for the manifest."""
        weights = self._best["weights"]
        network = self._task.train.network
        selected = {"iteration": self._best["iteration"], **self._best["score"]}
        policy = Policy(
            network=self._network(weights["actor_state_dict"]),
            hidden=tuple(network.hidden),
            activation=network.activation,
            observations=self.env.agent.observer.layout,
            times=self._task.times,
            robot=self._task.robot,
            env=self._task.env,
            training={"seed": self._task.train.seed, **selected},
            reference=self._task.reference,
        )
        save_policy(policy, out / POLICY_FILE)
        save(weights, out / WEIGHTS)
        for name, rows in ((SELECTION, self._history), (CURVE, self._curve)):
            if rows:
                pd.DataFrame(rows).to_csv(out / name, index=False, float_format="%.6g")
        return selected


def set_up_torch() -> None:
    """Use one thread, because sums depend on the number of threads, and no denormal numbers."""
    torch.set_num_threads(1)
    torch.set_flush_denormal(True)


def _with_unit_scales(state: Mapping[str, torch.Tensor]) -> dict[str, torch.Tensor]:
    """A network's state with standard deviation 1 for the observations that did not vary."""
    unvaried = state[STD] < UNVARIED
    return {**state, **{name: torch.where(unvaried, 1.0, state[name]) for name in (STD, VARIANCE)}}


def _noise_seed(seed: int, iteration: int) -> int:
    """Seed of a chunk's networks, environments and noise, from its first iteration."""
    if iteration == 0:
        return seed
    return int(np.random.SeedSequence([seed, iteration]).generate_state(1)[0])


def _copy(state: Mapping[str, torch.Tensor]) -> dict[str, torch.Tensor]:
    return {name: value.detach().cpu().clone() for name, value in state.items()}


def write_checkpoint(content: dict[str, Any], folder: Path) -> None:
    """Replace the last checkpoint by an atomic rename, and keep it as the one before.

    The file is synced to disk before the rename: a power cut leaves one of the two intact.
    """
    buffer = io.BytesIO()
    torch.save(content, buffer)
    partial = folder / f"{CHECKPOINT}.partial"
    with partial.open("wb") as file:
        file.write(_digest(buffer.getbuffer()) + b"\n")
        file.write(buffer.getbuffer())
        file.flush()
        os.fsync(file.fileno())
    if (folder / CHECKPOINT).exists():
        (folder / CHECKPOINT).replace(folder / BEFORE)
    partial.replace(folder / CHECKPOINT)


def read_checkpoint(folder: Path, say: Callable[[str], None]) -> dict[str, Any]:
    """The newest intact checkpoint, or an empty dictionary.

    Damaged ones are renamed to ``*.damaged``; ``say`` shows one line about each.
    """
    paths = [path for path in (folder / CHECKPOINT, folder / BEFORE) if path.exists()]
    for path, before in zip_longest(paths, paths[1:]):
        content = _content(path)
        if content is not None:
            return content
        path.replace(path.with_name(f"{path.name}.damaged"))
        start = "from the one before" if before else "anew"
        say(f"{path} is damaged and set aside: the training starts {start}")
    return {}


def _content(path: Path) -> dict[str, Any] | None:
    """Content of a checkpoint file; ``None`` if it is damaged.

    Raises:
        NotReadError: the file cannot be read; it may be intact.
    """
    try:
        digest, _, data = path.read_bytes().partition(b"\n")
    except OSError as error:
        raise not_read(error, path) from None
    if digest != _digest(data):
        return None
    return torch.load(io.BytesIO(data), map_location="cpu", weights_only=True)


def _digest(data: bytes | memoryview) -> bytes:
    return hashlib.sha256(data).hexdigest().encode()
