"""Training survives being killed, repeats itself and keeps the best policy."""

import errno
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from unittest.mock import Mock

import pytest
import torch

from slider.config.train import TrainConfig
from slider.control import POLICY_FILE
from slider.control.policy import load_policy
from slider.core.errors import UserError
from slider.core.job import Job
from slider.env.vec_env import Task, WalkingEnv
from slider.training.results import CURVE
from slider.training.selection import Score
from slider.training.trainer import (
    BEFORE,
    CHECKPOINT,
    WEIGHTS,
    Trainer,
    read_checkpoint,
    simulator,
    write_checkpoint,
)
from tests.env.synthetic import config, gait_table, make_guide

TINY = (
    "experiment=test",
    "train.standing.robots=8",
    "train.walking.robots=8",
    "train.standing.selection={duration: 0.2, warm_up: 0.1}",
    "train.walking.selection={interval: 1, duration: 0.2, warm_up: 0.1}",
    "train.standing.ppo.precision=float32",
    "train.walking.ppo.precision=float32",
)

ROUGH = ("train/walking/disturbance=robust", "train.walking.sensing=onboard")
# Trainings that must not depend on a kill: where they are configured, and what else.
KINDS = {
    "walking": ("train.walking", ROUGH),
    "terrain": ("finetuning", ("finetuning=outdoor",)),
    "warp": ("train.walking", (ROUGH[0], "train.walking.simulator=mujoco_warp")),
}
STEPS = 8  # of an iteration of theirs
SHORT = (
    *("iterations=5", "episode_length=0.4", "robots=8", f"steps_per_iteration={STEPS}"),
    *("ppo.precision=float32", "selection={interval: 2, robots: 1, duration: 0.2, warm_up: 0.1}"),
)


class Notes(list[tuple[int, dict[str, float]]]):
    """The metrics that it is given."""

    def __call__(self, metrics: Mapping[str, float], step: int) -> None:
        self.append((step, dict(metrics)))

    def series(self, name: str) -> list[tuple[int, float]]:
        return [(step, metrics[name]) for step, metrics in self if name in metrics]


def task(training: str = "walking", **changes) -> Task:
    whole = config(*TINY)
    train: TrainConfig = replace(getattr(whole.train, training), **changes)
    guide = make_guide() if training == "walking" else None
    table = gait_table()
    return Task(whole.robot, whole.env, train, table.times, guide, table.joints)


def of_kind(kind: str) -> Task:
    """A task of ``KINDS``: three chunks, in which episodes end."""
    training, overrides = KINDS[kind]
    short = (f"{training}.{value}" for value in SHORT)
    whole, table = config(*TINY, *overrides, *short), gait_table()
    train = whole.trainings[training]
    env = replace(whole.env, sensing=train.sensing)
    return Task(whole.robot, env, train, table.times, make_guide(), table.joints)


def job(work: Path, threads: int = 1) -> Job:
    return Job(work, threads=threads, log_metrics=Notes())


@dataclass(frozen=True)
class Run:
    """A training that has run, and what it left."""

    trainer: Trainer
    job: Job

    @property
    def notes(self) -> Notes:
        return self.job.log_metrics

    @property
    def iterations(self) -> list[int]:
        """Iterations that this trainer ran, by rsl-rl's own log."""
        return [step for step, _ in self.notes.series("episode/falls_per_second")]


def trained(work: Path, training: str = "walking", threads: int = 1, **changes) -> Run:
    made = job(work, threads)
    trainer = Trainer(task(training, **changes), made)
    trainer.run()
    return Run(trainer, made)


def actor(trainer: Trainer) -> dict[str, torch.Tensor]:
    return {k: v.clone() for k, v in trainer.algorithm.get_policy().state_dict().items()}


def same(one: Mapping[str, torch.Tensor], other: Mapping[str, torch.Tensor]) -> bool:
    return one.keys() == other.keys() and all(torch.equal(one[k], other[k]) for k in one)


def files(trainer: Trainer) -> dict[str, bytes]:
    """What a training that has run exports."""
    with TemporaryDirectory() as folder:
        trainer.export(Path(folder))
        return {path.name: path.read_bytes() for path in Path(folder).iterdir()}


@pytest.mark.parametrize("kind", KINDS)
def test_a_killed_training_gives_the_bytes_of_an_undisturbed_one(tmp_path, monkeypatch, kind):
    """Killed in each of its chunks; each time another number of threads goes on."""
    if kind == "warp":
        pytest.importorskip("mujoco_warp", reason="no extra gpu")
    simulate = simulator(of_kind(kind).train)
    whole = Trainer(of_kind(kind), job(tmp_path / "whole"), simulate)
    whole.run()
    real, left = WalkingEnv.step, 0

    def step(env: WalkingEnv, actions: torch.Tensor) -> tuple:
        nonlocal left
        left -= 1
        if left == 0:
            raise KeyboardInterrupt
        return real(env, actions)

    monkeypatch.setattr(WalkingEnv, "step", step)
    for threads, moment in ((1, 5), (2, 2 * STEPS + 3), (1, 2 * STEPS + 3)):
        left = moment
        with pytest.raises(KeyboardInterrupt):
            Trainer(of_kind(kind), job(tmp_path / "killed", threads), simulate).run()
    made = job(tmp_path / "killed", 2)
    last = Run(Trainer(of_kind(kind), made, simulate), made)
    last.trainer.run()
    assert last.iterations == [4]
    assert files(last.trainer) == files(whole)


def test_a_checkpoint_that_cannot_be_read_stays(tmp_path, monkeypatch):
    """One failed reading says nothing about the file."""
    write_checkpoint({"iteration": 50}, tmp_path)
    with monkeypatch.context() as patch:
        failing = Mock(side_effect=OSError(errno.EIO, "Input/output error"))
        patch.setattr(Path, "read_bytes", failing)
        with pytest.raises(UserError, match=r"checkpoint\.pt, found: Input/output error"):
            read_checkpoint(tmp_path, print)
    assert read_checkpoint(tmp_path, print)["iteration"] == 50


@pytest.mark.parametrize(
    ("damaged", "start"), [((CHECKPOINT,), "from the one before"), ((CHECKPOINT, BEFORE), "anew")]
)
def test_a_damaged_checkpoint_is_set_aside(tmp_path, damaged, start):
    """A changed byte of the last one, and nothing where the one before was."""
    trained(tmp_path, iterations=2)
    for name in damaged:
        content = (tmp_path / name).read_bytes()
        changed = content[:-9] + b"?" + content[-8:]
        (tmp_path / name).write_bytes(changed if name == CHECKPOINT else b"")
    said: list[str] = []
    made = replace(job(tmp_path), progress=said.append)
    run = Run(Trainer(task(iterations=3), made), made)
    assert len(said) == len(damaged)
    expected = f"{tmp_path / damaged[-1]} is damaged and set aside: the training starts {start}"
    assert said[-1] == expected
    assert {path.name for path in tmp_path.glob("*.damaged")} == {f"{n}.damaged" for n in damaged}
    run.trainer.run()
    rows = files(run.trainer)[CURVE].splitlines()[1:]
    assert len(rows) == read_checkpoint(tmp_path, print)["iteration"] == 3
    assert run.iterations[0] == (0 if start == "anew" else 1)


def test_another_seed_trains_another_policy(tmp_path):
    one, two = (trained(tmp_path / str(k), iterations=1, seed=k).trainer for k in (1, 2))
    assert not same(actor(one), actor(two))


def test_start_from_copies_weights_but_not_the_noise(tmp_path):
    trained(tmp_path / "standing", "standing", iterations=2).trainer.export(tmp_path)
    saved = torch.load(tmp_path / WEIGHTS, weights_only=True)
    with torch.no_grad():  # as if exploration had died down while standing
        saved["actor_state_dict"]["distribution.log_std_param"] -= 5.0
    torch.save(saved, tmp_path / WEIGHTS)
    walking = Trainer(task(), job(tmp_path / "walking"))
    initial = actor(walking)
    walking.start_from(tmp_path / WEIGHTS)
    found = walking.algorithm.save()
    for part in ("actor_state_dict", "critic_state_dict"):
        unvaried = saved[part]["obs_normalizer._std"] == 0.0
        assert unvaried.any()
        assert not unvaried.all()
        for name, value in found[part].items():
            noise = name.startswith("distribution.")
            expected = initial[name] if noise else saved[part][name]
            if name in ("obs_normalizer._std", "obs_normalizer._var"):
                expected = torch.where(unvaried, 1.0, expected)
            assert torch.equal(value, expected), name


def test_the_best_policy_is_exported_not_the_last(tmp_path):
    trainer = Trainer(task(iterations=3), job(tmp_path))
    scores, judged = iter([3.0, 1.0, 2.0]), []

    def score(network) -> Score:
        judged.append(network.mlp[0].weight.clone())
        return Score(value=next(scores), success=1.0, tracked=1.0, speed_error=0.1, flight=0.0)

    trainer.selector.score = score
    trainer.run()
    selected = trainer.export(tmp_path)
    assert (selected["value"], selected["iteration"]) == (1.0, 2)
    exported = load_policy(tmp_path / POLICY_FILE).network.mlp[0].weight
    assert [torch.equal(exported, weight) for weight in judged] == [False, True, False]


def test_the_exported_policy_is_the_one_that_was_judged(tmp_path):
    trainer = trained(tmp_path, iterations=1).trainer
    selected = trainer.export(tmp_path)
    policy = load_policy(tmp_path / POLICY_FILE)
    assert policy.observations == trainer.env.agent.observer.layout
    assert policy.times is not None
    assert (policy.robot, policy.env) == (task().robot, task().env)
    assert policy.training == {"seed": task().train.seed, **selected}
    assert trainer.selector.score(policy.network).value == selected["value"]


def test_blow_ups_are_reported_outside_the_result(tmp_path):
    made = job(tmp_path)
    trainer = Trainer(task(iterations=1), made)
    trainer.env.physics.qvel[3, 6:] = 1e9
    trainer.run()
    assert made.metadata["blow_ups"] == 1


def test_an_error_of_the_simulation_ends_the_training_before_its_checkpoint(tmp_path):
    """Such as lost contacts on a device, which nobody looks for in a control step."""
    trainer = Trainer(task(iterations=1), job(tmp_path))

    def check() -> None:
        raise UserError("expected no overflow")

    trainer.env.physics.check = check
    with pytest.raises(UserError, match="expected no overflow"):
        trainer.run()
    assert not list(tmp_path.glob("checkpoint*"))


def test_threads_change_no_weight(tmp_path):
    """Large enough for torch to share the work out, were it asked to."""
    network = replace(task().train.network, hidden=[256, 256, 256])
    changes = {"robots": 128, "steps_per_iteration": 24, "iterations": 1, "network": network}
    one, two = (trained(tmp_path / str(threads), threads=threads, **changes) for threads in (1, 2))
    assert same(actor(one.trainer), actor(two.trainer))
