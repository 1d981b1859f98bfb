"""rsl-rl's scalars reach the tracker in one call per iteration."""

from slider.training.ppo import TrackerLogWriter
from tests.training.test_trainer import Notes, trained


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
    trainer = trained(tmp_path, iterations=3)
    notes = trainer._job.tracker
    assert isinstance(notes, Notes)
    steps = [step for step, metrics in notes.metrics if "episode/falls_per_second" in metrics]
    assert steps == [0, 1, 2]
    assert [step for step, _ in notes.series("selection/value")] == [1, 2, 3]
    assert len(notes.metrics) == 6
    rewards = {name for _, metrics in notes.metrics for name in metrics if "reward/" in name}
    assert {f"reward/{name}" for name in trainer._task.train.reward.terms} <= rewards
    assert all(
        isinstance(value, float) for _, metrics in notes.metrics for value in metrics.values()
    )
