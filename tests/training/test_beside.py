"""With two threads the critic is computed beside the actor, and not a bit changes."""

import gc
import threading
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import pytest
import torch

from tests.env.synthetic import config
from tests.training.test_trainer import TINY, Trainer, actor, job, same, task


def make(folder: Path, threads: int, **changes) -> Trainer:
    """Large enough for torch to share the work out, were it asked to."""
    network = replace(config(*TINY).train.walking.network, hidden=[256, 256, 256])
    changes = {"robots": 256, "steps_per_iteration": 24, "network": network, **changes}
    return Trainer(task(**changes), job(folder / str(threads), threads))


def critic(trainer: Trainer) -> dict[str, torch.Tensor]:
    return trainer.algorithm.save()["critic_state_dict"]


def first_layer(trainer: Trainer) -> torch.nn.Linear:
    return cast(Any, trainer.algorithm.critic).mlp[0]


def states(trainer: Trainer) -> list[torch.Tensor]:
    moments = trainer.algorithm.save()["optimizer_state_dict"]["state"]
    return [moments[k][name] for k in moments for name in ("exp_avg", "exp_avg_sq")]


@pytest.mark.parametrize("precision", ["float32", "bfloat16"])
@pytest.mark.parametrize("symmetry", ["none", "augmentation", "loss"])
def test_networks_and_moments_are_those_of_one_thread(tmp_path, precision, symmetry):
    ppo = replace(config(*TINY).train.walking.ppo, precision=precision, symmetry=symmetry)
    trainers = []
    for threads in (1, 2):
        trainers.append(make(tmp_path, threads, ppo=ppo, iterations=2))
        before = critic(trainers[-1])["mlp.0.weight"].clone()
        trainers[-1].run()
        assert not torch.equal(before, critic(trainers[-1])["mlp.0.weight"])
    one, two = trainers
    assert same(actor(one), actor(two))
    assert same(critic(one), critic(two))
    assert all(map(torch.equal, states(one), states(two)))


def test_the_critic_has_a_thread_where_there_are_two(tmp_path):
    for threads, name in ((1, threading.main_thread().name), (2, "critic_0")):
        trainer = make(tmp_path, threads, iterations=1)
        forward, backward = set(), set()
        first = first_layer(trainer)
        first.register_forward_hook(lambda *_, f=forward: f.add(threading.current_thread().name))
        first.weight.register_hook(lambda _, b=backward: b.add(threading.current_thread().name))
        trainer.run()
        alone = {threading.main_thread().name}  # values after the last step: the actor is not asked
        assert forward == {name} | alone
        assert backward == {name}


def test_the_critic_is_differentiated_without_autocast(tmp_path):
    """As rsl-rl does it: a product in single precision stays one."""
    ppo = replace(config(*TINY).train.walking.ppo, precision="bfloat16")
    trainer, seen = make(tmp_path, 2, ppo=ppo, iterations=1), set()
    first_layer(trainer).weight.register_hook(lambda _: seen.add(torch.is_autocast_enabled("cpu")))
    trainer.run()
    assert seen == {False}


def test_nothing_is_left_of_a_training(tmp_path):
    before = set(threading.enumerate())
    trainer = make(tmp_path, 2, iterations=1)
    trainer.run()
    threads = [t for t in threading.enumerate() if t not in before and t.name == "critic_0"]
    assert len(threads) == 1
    del trainer
    gc.collect()
    threads[0].join(timeout=10.0)
    assert not threads[0].is_alive()


def test_an_error_of_the_critic_ends_the_training(tmp_path):
    two = make(tmp_path, 2, iterations=1)

    def fail(_) -> None:
        raise ValueError("expected no failure")

    first_layer(two).weight.register_hook(fail)
    with pytest.raises(ValueError, match="expected no failure"):
        two.run()
