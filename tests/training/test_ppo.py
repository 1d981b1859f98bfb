"""PPO: settings, scalars, noise, averaged actor and reflected samples."""

from dataclasses import replace

import pytest
import torch

from slider.training.ppo import AnnealedPPO, MetricsWriter
from slider.training.trainer import Trainer
from tests.env.synthetic import config
from tests.training.test_trainer import TINY, Notes, actor, job, same, task, trained


def test_one_call_per_step():
    notes = Notes()
    curve: list[dict[str, float]] = []
    writer = MetricsWriter(notes, curve)
    for step in range(3):
        writer.add_scalar("Loss/value", 0.1 * step, step)
        writer.add_scalar("/reward/alive", 1.0, step)
        writer.add_scalar("Train/mean_reward/time", 3.0, 17)  # against the clock: dropped
        writer.add_scalar("Perf/total_fps", 1e4, step)
    assert [step for step, _ in notes] == [0, 1]
    writer.stop()
    writer.stop()
    assert notes == [
        (step, {"Loss/value": 0.1 * step, "reward/alive": 1.0, "Perf/total_fps": 1e4})
        for step in range(3)
    ]
    for (step, metrics), row in zip(notes, curve, strict=True):
        del metrics["Perf/total_fps"]  # the curve is the same on any machine
        assert row == {"iteration": step, **metrics}


def actors_of(trainer: Trainer) -> list[dict[str, torch.Tensor]]:
    """Train, and give the weights after each update."""
    seen, update = [], AnnealedPPO.update

    def watched(algorithm: AnnealedPPO) -> dict[str, float]:
        losses = update(algorithm)
        seen.append(actor(trainer))
        return losses

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(AnnealedPPO, "update", watched)
        trainer.run()
    return seen


@pytest.mark.parametrize("actor_ema", [0.0, 0.9])
def test_the_average_of_the_actor_is_exported(tmp_path, actor_ema):
    """Weights after each update enter an average, which is what is judged, kept and resumed."""
    ppo = replace(config(*TINY).train.walking.ppo, actor_ema=actor_ema)
    trainer = Trainer(task(iterations=3, ppo=ppo), job(tmp_path))
    seen = actors_of(trainer)
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
    bounds = {"initial_std": 0.5, "std_max": 0.4, "std_final": 0.1, "anneal_from": 0.5}
    network = replace(config(*TINY).train.walking.network, **bounds)
    train = {"iterations": 4, "network": network}
    actors = actors_of(Trainer(task(**train), job(tmp_path)))
    noise = [each["distribution.log_std_param"].exp().max().item() for each in actors]
    assert noise == pytest.approx([0.4, 0.4, 0.2, 0.1], rel=1e-5)
    # the share of the iterations counts what was done before
    resumed = trained(tmp_path, **{**train, "iterations": 8})
    noise = actor(resumed.trainer)["distribution.log_std_param"].exp()
    assert noise.max().item() == pytest.approx(0.1)
    assert resumed.iterations == [4, 5, 6, 7]
