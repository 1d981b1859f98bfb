"""The products beside an update are those that the update makes."""

import pytest
import torch
from torch.utils.flop_counter import FlopCounterMode

from slider.bench.products import products
from slider.training.trainer import Trainer
from tests.training.test_trainer import job, task


@pytest.mark.parametrize("dtype", [torch.float32, torch.bfloat16])
def test_they_are_as_many_as_in_the_update(tmp_path, dtype):
    trainer = Trainer(task(iterations=1), job(tmp_path))
    counted, update = FlopCounterMode(display=False), trainer.algorithm.update

    def watched():
        with counted:
            return update()

    trainer.algorithm.update = watched  # type: ignore[method-assign]
    trainer.run()
    train = task().train
    batches = train.ppo.mini_batches
    batch = train.robots * train.steps_per_iteration // batches
    networks = trainer.algorithm.actor, trainer.algorithm.critic
    multiply = products(networks, batch, batches * train.ppo.epochs, dtype)
    with FlopCounterMode(display=False) as alone:
        multiply()
    assert alone.get_total_flops() == counted.get_total_flops() > 0
