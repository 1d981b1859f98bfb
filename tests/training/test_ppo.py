"""Our configuration reaches rsl-rl, its scalars reach the tracker, a call per iteration."""

import pytest

from slider.config.train import TrainConfig
from slider.core.job import NoTracker
from slider.training.annealed_ppo import AnnealedPPO, NoiseBound
from slider.training.ppo import TrackerLogWriter, runner_config
from tests.env.synthetic import config
from tests.training.test_trainer import Notes, task, trained


def test_one_call_per_step():
    notes = Notes()
    curve: list[dict[str, float]] = []
    writer = TrackerLogWriter(notes, curve)
    for step in range(3):
        writer.add_scalar("Loss/value", 0.1 * step, step)
        writer.add_scalar("/reward/alive", 1.0, step)
    assert [step for step, _ in notes.metrics] == [0, 1]
    writer.stop()
    writer.stop()
    assert notes.metrics == [
        (step, {"Loss/value": 0.1 * step, "reward/alive": 1.0}) for step in range(3)
    ]
    assert curve == [{"iteration": step, **metrics} for step, metrics in notes.metrics]


def test_scalars_against_the_clock_are_dropped():
    notes = Notes()
    curve: list[dict[str, float]] = []
    writer = TrackerLogWriter(notes, curve)
    writer.add_scalar("Train/mean_reward/time", 3.0, 17)
    writer.add_scalar("Train/mean_reward", 3.0, 2)
    writer.add_scalar("Perf/total_fps", 1e4, 2)
    writer.stop()
    assert notes.metrics == [(2, {"Train/mean_reward": 3.0, "Perf/total_fps": 1e4})]
    assert curve == [{"iteration": 2, "Train/mean_reward": 3.0}]  # the same on any machine


def test_a_training_logs_once_per_iteration_and_once_per_check(tmp_path):
    notes = trained(tmp_path, iterations=3).notes
    steps = [step for step, metrics in notes.metrics if "episode/falls_per_second" in metrics]
    assert steps == [0, 1, 2]
    assert [step for step, _ in notes.series("selection/value")] == [1, 2, 3]
    assert len(notes.metrics) == 6
    rewards = {name for _, metrics in notes.metrics for name in metrics if "reward/" in name}
    assert {f"reward/{name}" for name in task().train.reward.active} <= rewards
    assert all(
        isinstance(value, float) for _, metrics in notes.metrics for value in metrics.values()
    )


def test_our_settings_in_rsl_rls_words():
    """Every value of the paper's configuration arrives where rsl-rl looks for it."""
    train = config("experiment=paper", "train.walking.ppo.precision=float32").train.walking
    settings = runner_config(train, NoTracker(), [])
    own, network = train.ppo, train.network
    model = {
        "class_name": "MLPModel",
        "hidden_dims": [256, 256, 256],
        "activation": network.activation,
        "obs_normalization": True,
    }
    noise = {
        "class_name": "GaussianDistribution",
        "init_std": network.initial_std,
        "std_type": "log",
        "std_range": (network.std_min, network.std_max),
    }
    assert settings["critic"] == model
    assert settings["actor"] == {**model, "distribution_cfg": noise}
    assert settings["num_steps_per_env"] == train.steps_per_iteration
    assert settings["algorithm"] == {
        "class_name": AnnealedPPO,
        "actor_ema": own.actor_ema,
        "noise": NoiseBound(
            first=network.std_max,
            last=network.std_final,
            start=network.anneal_from,
            updates=train.iterations,
        ),
        "num_learning_epochs": own.epochs,
        "num_mini_batches": own.mini_batches,
        "clip_param": own.clip,
        "gamma": own.gamma,
        "lam": own.lam,
        "value_loss_coef": own.value_coefficient,
        "entropy_coef": own.entropy_coefficient,
        "learning_rate": own.learning_rate,
        "schedule": own.schedule,
        "desired_kl": own.desired_kl,
        "max_grad_norm": own.max_grad_norm,
        "use_mixed_precision": False,
        "symmetry_cfg": None,
    }


@pytest.mark.parametrize(("precision", "mixed"), [("bfloat16", True), ("float32", False)])
def test_precision(precision, mixed):
    settings = runner_config(_with_precision(precision), NoTracker(), [])
    assert settings["algorithm"]["use_mixed_precision"] is mixed


def test_a_training_does_not_choose_its_precision():
    with pytest.raises(ValueError, match="expected float32 or bfloat16, found auto"):
        runner_config(_with_precision("auto"), NoTracker(), [])


def _with_precision(precision: str) -> TrainConfig:
    return config(f"train.walking.ppo.precision={precision}").train.walking
