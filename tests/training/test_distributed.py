"""Several processes train one policy on MuJoCo Warp; the processor and gloo stand for GPUs."""

import os
import time
from functools import partial
from pathlib import Path
from typing import Any

import pytest
import torch
from rsl_rl.runners import OnPolicyRunner

from slider.core.errors import UserError
from slider.core.job import Job
from slider.training.distributed import device_of, launch, rank
from slider.training.results import SELECTION
from slider.training.trainer import Trainer
from tests.training.test_trainer import actor, same, task

pytest.importorskip("mujoco_warp", reason="no extra gpu")
from slider.env.warp import WarpPhysics

SIMULATE = partial(WarpPhysics, device="cpu")


def of_processors(runner: OnPolicyRunner) -> None:
    """rsl-rl's own, but for the device and the backend, which are ``cuda`` and ``nccl`` there."""
    place, count = rank(), int(os.environ["WORLD_SIZE"])
    runner.gpu_world_size, runner.is_distributed = count, True
    runner.gpu_local_rank = runner.gpu_global_rank = place
    runner.cfg["multi_gpu"] = {"global_rank": place, "local_rank": place, "world_size": count}
    torch.distributed.init_process_group("gloo", rank=place, world_size=count)


def train(folder: Path) -> dict[str, Any]:
    OnPolicyRunner._configure_multi_gpu = of_processors  # type: ignore[method-assign]
    made = Job(folder)
    trainer = Trainer(task(iterations=2), made, SIMULATE)
    first = trainer.env.agent.command.clone()
    trainer.run()
    here = {"actor": actor(trainer), "speeds": first, "checks": len(trainer._history)}
    everyone: list[Any] = [None, None]
    torch.distributed.all_gather_object(everyone, here)
    return {"all": everyone, "summary": trainer.export(folder) if rank() == 0 else None}


def test_processes_share_a_policy_but_no_robots(tmp_path):
    found = launch(2, train, tmp_path)
    one, other = found["all"]
    assert same(one["actor"], other["actor"])
    alone = Trainer(task(iterations=2), Job(tmp_path / "alone"), SIMULATE)
    alone.run()
    assert not same(one["actor"], actor(alone))
    assert not (one["speeds"] == other["speeds"]).all()
    assert (one["checks"], other["checks"]) == (2, 0)  # the first judges and writes for all
    assert found["summary"]["iteration"] in (1, 2)
    assert len((tmp_path / SELECTION).read_text().splitlines()) == 3


def overflow() -> None:
    if rank() == 1:
        raise UserError("MuJoCo Warp: expected no overflow, found 3")
    time.sleep(60)


def test_what_one_process_says_is_one_line():
    with pytest.raises(UserError, match=r"process 1 of 2: .*expected no overflow, found 3$"):
        launch(2, overflow)


def test_one_process_is_this_one():
    assert launch(1, os.getpid) == os.getpid()
    assert rank() == 0


def test_a_process_has_the_device_of_its_rank(monkeypatch):
    assert (device_of("cpu"), device_of("cuda")) == ("cpu", "cuda:0")
    monkeypatch.setenv("LOCAL_RANK", "3")
    assert (device_of("cpu"), device_of("cuda")) == ("cpu", "cuda:3")
