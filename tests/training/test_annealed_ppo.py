"""The action noise is bounded by its schedule, and an average of the actor is exported."""

from dataclasses import replace

import pytest
import torch

from slider.training.trainer import Trainer
from tests.env.synthetic import config
from tests.training.test_trainer import TINY, actor, job, same, task, trained


@pytest.mark.parametrize("actor_ema", [0.0, 0.9])
def test_the_average_of_the_actor_is_exported(tmp_path, actor_ema):
    """Weights after each update enter an average, which is what is judged, kept and resumed."""
    ppo = replace(config(*TINY).train.walking.ppo, actor_ema=actor_ema)
    trainer = Trainer(task(iterations=3, ppo=ppo), job(tmp_path))
    seen, update = [], trainer.algorithm.update

    def watched():
        losses = update()
        seen.append(actor(trainer))
        return losses

    trainer.algorithm.update = watched  # type: ignore[method-assign]
    trainer.run()
    expected = seen[0]
    for later in seen[1:]:
        expected = {k: actor_ema * v + (1 - actor_ema) * later[k] for k, v in expected.items()}
    found = trainer.algorithm.averaged_actor.state_dict()
    for name in ("mlp.0.weight", "mlp.4.bias", "obs_normalizer._mean"):
        torch.testing.assert_close(found[name], expected[name])
    assert same(found, actor(trainer)) == (actor_ema == 0.0)
    resumed = trained(tmp_path, iterations=3, ppo=ppo).trainer
    assert same(resumed.algorithm.averaged_actor.state_dict(), found)


def test_the_noise_is_bounded_and_its_bound_falls_to_the_end(tmp_path):
    network = replace(
        config(*TINY).train.walking.network,
        initial_std=0.5,
        std_max=0.4,
        std_final=0.1,
        anneal_from=0.5,
    )
    train = {"iterations": 4, "network": network}
    trainer = Trainer(task(**train), job(tmp_path))
    seen, update = [], trainer.algorithm.update

    def watched():
        losses = update()
        seen.append(actor(trainer)["distribution.log_std_param"].exp().max().item())
        return losses

    trainer.algorithm.update = watched  # type: ignore[method-assign]
    trainer.run()
    assert seen == pytest.approx([0.4, 0.4, 0.2, 0.1], rel=1e-5)
    # the share of the iterations counts what was done before
    resumed = trained(tmp_path, **{**train, "iterations": 8})
    noise = actor(resumed.trainer)["distribution.log_std_param"].exp()
    assert noise.max().item() == pytest.approx(0.1)
    assert resumed.iterations == [4, 5, 6, 7]
