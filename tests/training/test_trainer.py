"""Training improves a policy, survives being killed and repeats itself."""

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from slider.config.train import RewardConfig, RewardTerm, TrainConfig
from slider.control.policy_file import load_policy
from slider.core.job import Job, NoTracker
from slider.training.selection import Score
from slider.training.task import Task
from slider.training.trainer import CHECKPOINT, CURVE, POLICY, SELECTION, WEIGHTS, Trainer
from tests.env.synthetic import config, gait_table, make_guide

TINY = (
    "experiment=test",
    "train.standing.robots=8",
    "train.walking.robots=8",
    "train.walking.selection.interval=1",
    "train.standing.selection.duration=0.2",
    "train.walking.selection.duration=0.2",
    "train.standing.selection.warm_up=0.1",
    "train.walking.selection.warm_up=0.1",
)


class Notes(NoTracker):
    """Keeps the metrics that it is given."""

    def __init__(self) -> None:
        self.metrics: list[tuple[int, dict[str, float]]] = []

    def log_metrics(self, metrics: Mapping[str, float], step: int) -> None:
        self.metrics.append((step, dict(metrics)))

    def series(self, name: str) -> list[tuple[int, float]]:
        return [(step, metrics[name]) for step, metrics in self.metrics if name in metrics]


def task(training: str = "walking", **changes) -> Task:
    whole = config(*TINY)
    train: TrainConfig = replace(getattr(whole.train, training), **changes)
    guide = make_guide() if training == "walking" else None
    table = gait_table()
    return Task(whole.robot, whole.env, train, table.times, guide, table.joints)


def job(work: Path) -> Job:
    return Job(work, threads=1, tracker=Notes())


def trained(work: Path, **changes) -> Trainer:
    trainer = Trainer(task(**changes), job(work))
    trainer.run()
    return trainer


def actor(trainer: Trainer) -> dict[str, torch.Tensor]:
    return {k: v.clone() for k, v in trainer._algorithm.get_policy().state_dict().items()}


def same(one: Mapping[str, torch.Tensor], other: Mapping[str, torch.Tensor]) -> bool:
    return one.keys() == other.keys() and all(torch.equal(one[k], other[k]) for k in one)


def iterations(trainer: Trainer) -> list[int]:
    """Iterations that this trainer ran, by rsl-rl's own log."""
    return [step for step, _ in trainer._job.tracker.series("episode/falls_per_second")]  # type: ignore


@pytest.mark.learn
def test_standing_is_learned_in_half_a_minute(tmp_path):
    """Falls become rare; before training no robot stands for three seconds."""
    whole = config(*TINY)
    standing = whole.train.standing
    terms = {
        "alive": RewardTerm(0.2),
        "upright": RewardTerm(0.4, {"width": 0.03}),
        "height": RewardTerm(0.4, {"width": 0.0025}),
        "action_rate": RewardTerm(-0.006),
        "roll_pitch_rate": RewardTerm(-0.02),
    }
    trainer = Trainer(
        task(
            "standing",
            iterations=75,
            robots=128,
            steps_per_iteration=24,
            reward=RewardConfig(terms, scale=1.0, floor=0.0, on_fall=-1.0),
            network=replace(standing.network, hidden=[64, 64]),
            ppo=replace(standing.ppo, precision="float32"),
            selection=replace(standing.selection, interval=15, robots=20, duration=3.0),
        ),
        job(tmp_path),
    )
    before = trainer._check()
    trainer._best, trainer._history = {}, []
    trainer.run()
    after = trainer._best["score"]
    assert before.success <= 0.1
    assert after["success"] >= 0.4
    assert after["value"] < before.value - 3.0
    falls = [value for _, value in trainer._job.tracker.series("episode/falls_per_second")]  # type: ignore
    assert len(falls) == 75
    assert np.mean(falls[-5:]) < 0.75 * np.mean(falls[1:6])


def test_a_killed_training_goes_on_where_it_was(tmp_path):
    first = trained(tmp_path, iterations=2)
    assert iterations(first) == [0, 1]
    assert "resumed" not in first._job.volatile
    second = trained(tmp_path, iterations=5)
    assert second._job.volatile["resumed"] is True
    assert iterations(second) == [2, 3, 4]
    assert second._iteration == 5
    assert [row["iteration"] for row in second._history] == [1, 2, 3, 4, 5]
    assert second._history[:2] == first._history
    assert [row["iteration"] for row in second._curve] == [0, 1, 2, 3, 4]
    assert second._curve[:2] == first._curve
    third = trained(tmp_path, iterations=5)
    assert iterations(third) == []
    assert same(actor(third), actor(second))


def test_a_resumed_training_meets_other_commands_and_disturbances(tmp_path):
    fresh = Trainer(task(), job(tmp_path))
    commands = [fresh._env._agent.command[:, 0].copy()]
    trained(tmp_path, iterations=1)
    for _ in range(2):
        resumed = Trainer(task(), job(tmp_path))
        commands.append(resumed._env._agent.command[:, 0].copy())
        assert resumed._env._train.seed != fresh._env._train.seed
    told_to_go = commands[1][commands[1] != 0]  # a share is told to stand, now and then
    assert len(told_to_go) > 4
    assert not np.isin(told_to_go, commands[0]).any()
    np.testing.assert_array_equal(commands[1], commands[2])


def test_a_resumed_training_spreads_its_resets(tmp_path):
    """Nobody falls in a training that went far: of one age, all would time out at once."""
    ages = []
    for iterations in (1, 2):
        trainer = Trainer(task(iterations=iterations), job(tmp_path))
        learn = trainer._runner.learn

        def note(*arguments, learn=learn, trainer=trainer, **options):
            learn(*arguments, **options)
            ages.append(trainer._env.episode_length_buf.max().item())

        trainer._runner.learn = note
        trainer.run()
    steps = task().train.steps_per_iteration
    assert ages[0] == steps
    assert ages[1] > 2 * steps


def test_the_checkpoint_restores_networks_and_optimiser(tmp_path):
    first = trained(tmp_path, iterations=2)
    second = Trainer(task(), job(tmp_path))
    assert not same(actor(first), actor(second))
    second._resume()
    assert same(actor(first), actor(second))
    one, other = (t._algorithm.save() for t in (first, second))
    assert same(one["critic_state_dict"], other["critic_state_dict"])
    moments = [content["optimizer_state_dict"]["state"][0]["exp_avg"] for content in (one, other)]
    assert moments[0].abs().max() > 0
    assert torch.equal(*moments)


def test_a_half_written_checkpoint_is_never_read(tmp_path):
    trained(tmp_path, iterations=1)
    (tmp_path / f"{CHECKPOINT}.partial").write_bytes(b"killed while writing")
    assert trained(tmp_path, iterations=2)._iteration == 2
    assert [path.name for path in tmp_path.glob("*.pt*")] == [CHECKPOINT]


def test_the_last_chunk_is_shorter_rather_than_past_the_target(tmp_path):
    selection = replace(config(*TINY).train.walking.selection, interval=2)
    trainer = trained(tmp_path, iterations=3, selection=selection)
    assert iterations(trainer) == [0, 1, 2]
    assert [row["iteration"] for row in trainer._history] == [2, 3]


def test_same_seed_same_policy(tmp_path):
    runs = [trained(tmp_path / str(k), iterations=2, seed=seed) for k, seed in enumerate((1, 1, 2))]
    assert same(actor(runs[0]), actor(runs[1]))
    assert runs[0]._history == runs[1]._history
    assert not same(actor(runs[0]), actor(runs[2]))
    files = []
    for run in runs[:2]:
        out = tmp_path / f"out{len(files)}"
        out.mkdir()
        run.export(out)
        files.append({path.name: path.read_bytes() for path in out.iterdir()})
    assert files[0] == files[1]
    assert set(files[0]) == {POLICY, WEIGHTS, SELECTION, CURVE}


def test_the_learning_curve_has_every_reward_term(tmp_path):
    trainer = trained(tmp_path, iterations=2)
    trainer.export(tmp_path)
    header, *rows = (tmp_path / CURVE).read_text().splitlines()
    columns = header.split(",")
    assert columns[0] == "iteration"
    assert {f"reward/{name}" for name in trainer._task.train.reward.terms} <= set(columns)
    assert [row.split(",")[0] for row in rows] == ["0", "1"]
    assert {len(row.split(",")) for row in rows} == {len(columns)}


def test_what_people_follow_is_tracked(tmp_path):
    """Reward terms, steps per second, survival, tracking error and blow-ups, by iteration."""
    trainer = trained(tmp_path, iterations=2)
    notes = trainer._job.tracker
    assert isinstance(notes, Notes)
    each = ("Perf/total_fps", "episode/falls_per_second", "episode/speed_error", "episode/diverged")
    terms = [f"reward/{name}" for name in trainer._task.train.reward.terms]
    for name in (*each, *terms, "Loss/surrogate", "Policy/mean_std"):
        assert [step for step, _ in notes.series(name)] == [0, 1], name
    for name in ("selection/success", "selection/speed_error", "selection/value"):
        assert [step for step, _ in notes.series(name)] == [1, 2], name


def test_progress_is_one_line_with_time_left_and_success(tmp_path):
    lines: list[str] = []
    Trainer(task(iterations=2), replace(job(tmp_path), progress=lines.append)).run()
    assert len(lines) == 2
    for iteration, text in enumerate(lines, start=1):
        assert re.match(
            rf"iteration {iteration}/2, [\d.]+ k steps/s, [\d.]+ min left, success \d+ %", text
        ), text


@pytest.mark.parametrize(
    ("success", "end"),
    [(0.5, "success 50 %, speed error 0.125 m/s, score 3.000"), (0.0, "success 0 %")],
)
def test_progress_names_a_speed_error_where_robots_survived(tmp_path, success, end):
    lines: list[str] = []
    trainer = Trainer(task(), replace(job(tmp_path), progress=lines.append))
    trainer._report(Score(value=3.0, success=success, speed_error=0.125, flight=0.0), 1.0)
    assert lines[0].endswith(f"min left, {end}")


def test_start_from_copies_weights_but_not_the_noise(tmp_path):
    standing = trained(tmp_path / "standing", training="standing", iterations=2)
    standing.export(tmp_path)
    saved = torch.load(tmp_path / WEIGHTS, weights_only=True)
    with torch.no_grad():  # as if exploration had died down while standing
        for name in saved["actor_state_dict"]:
            if name.startswith("distribution."):
                saved["actor_state_dict"][name] -= 5.0
    torch.save(saved, tmp_path / WEIGHTS)
    walking = Trainer(task(), job(tmp_path / "walking"))
    initial = actor(walking)
    walking.start_from(tmp_path / WEIGHTS)
    after = actor(walking)
    noise = [name for name in after if name.startswith("distribution.")]
    assert noise
    critic = walking._algorithm.save()["critic_state_dict"]
    scales = [f"obs_normalizer.{name}" for name in ("_std", "_var")]
    for name, value in after.items():
        if name not in scales:
            expected = initial[name] if name in noise else saved["actor_state_dict"][name]
            assert torch.equal(value, expected), name
    rest = {name: value for name, value in critic.items() if name not in scales}
    assert same(rest, {name: saved["critic_state_dict"][name] for name in rest})
    for new, old in ((after, saved["actor_state_dict"]), (critic, saved["critic_state_dict"])):
        unvaried = old[scales[0]] == 0.0
        assert unvaried.any()
        assert not unvaried.all()
        for name in scales:
            assert torch.equal(new[name], torch.where(unvaried, 1.0, old[name]))


def test_walking_begins_as_standing_ends(tmp_path):
    """A command, which standing never saw, enters the network as it is."""
    standing = trained(tmp_path / "standing", training="standing", iterations=2)
    standing.export(tmp_path)
    walking = Trainer(task(), job(tmp_path / "walking"))
    walking.start_from(tmp_path / WEIGHTS)
    seen = walking._env.get_observations()
    layout = walking._env.observation_layout
    first = sum(list(layout.values())[: list(layout).index("command")])
    command = seen["policy"][:, first : first + 3]
    assert command[:, 0].max() > 0.5  # m/s
    normalised = walking._algorithm.get_policy().obs_normalizer(seen["policy"])
    torch.testing.assert_close(normalised[:, first : first + 3], command, rtol=0.02, atol=0)


def test_the_best_policy_is_exported_not_the_last(tmp_path):
    trainer = Trainer(task(iterations=2), job(tmp_path))
    scores = iter([3.0, 1.0, 2.0])
    real = trainer._selector.score
    trainer._selector.score = lambda network: replace(real(network), value=next(scores))  # type: ignore
    weights = []
    for _ in range(3):
        with torch.no_grad():
            for parameter in trainer._algorithm.get_policy().mlp.parameters():
                parameter.add_(0.01)
        trainer._check()
        weights.append(actor(trainer))
    facts = trainer.export(tmp_path)
    assert facts["value"] == 1.0
    exported = load_policy(tmp_path / POLICY).network
    assert torch.equal(exported.mlp[0].weight, weights[1]["mlp.0.weight"])
    assert not torch.equal(exported.mlp[0].weight, weights[2]["mlp.0.weight"])


@pytest.mark.parametrize("actor_ema", [0.0, 0.9])
def test_the_average_of_the_actor_is_exported(tmp_path, actor_ema):
    """Weights after each update enter an average, which is what is judged, kept and resumed."""
    ppo = replace(config(*TINY).train.walking.ppo, actor_ema=actor_ema)
    trainer = Trainer(task(iterations=3, ppo=ppo), job(tmp_path))
    seen, update = [], trainer._algorithm.update

    def watched():
        losses = update()
        seen.append(actor(trainer))
        return losses

    trainer._algorithm.update = watched  # type: ignore
    trainer.run()
    expected = seen[0]
    for later in seen[1:]:
        expected = {k: actor_ema * v + (1 - actor_ema) * later[k] for k, v in expected.items()}
    found = trainer._algorithm.averaged_actor.state_dict()
    for name in ("mlp.0.weight", "mlp.4.bias", "obs_normalizer._mean"):
        torch.testing.assert_close(found[name], expected[name])
    assert same(found, actor(trainer)) == (actor_ema == 0.0)
    resumed = Trainer(task(iterations=3, ppo=ppo), job(tmp_path))
    resumed._resume()
    assert same(resumed._algorithm.averaged_actor.state_dict(), found)


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
    seen, update = [], trainer._algorithm.update

    def watched():
        losses = update()
        seen.append(actor(trainer)["distribution.log_std_param"].exp().max().item())
        return losses

    trainer._algorithm.update = watched  # type: ignore
    trainer.run()
    assert seen == pytest.approx([0.4, 0.4, 0.2, 0.1], rel=1e-5)
    resumed = Trainer(task(**{**train, "iterations": 8}), job(tmp_path))
    resumed.run()  # the share of the iterations counts what was done before
    noise = actor(resumed)["distribution.log_std_param"].exp()
    assert noise.max().item() == pytest.approx(0.1)
    assert len(iterations(resumed)) == 4


@pytest.mark.parametrize("part", ["actor_ema", "checks"])
def test_neither_the_average_nor_the_checks_change_the_learning(tmp_path, part):
    walking = config(*TINY).train.walking
    choices = {
        "actor_ema": [{"ppo": replace(walking.ppo, actor_ema=share)} for share in (0.0, 0.9)],
        "checks": [{"selection": replace(walking.selection, interval=k)} for k in (1, 2)],
    }
    one, other = (
        trained(tmp_path / str(k), iterations=4, **changes)
        for k, changes in enumerate(choices[part])
    )
    assert same(actor(one), actor(other))


def test_the_exported_policy_is_the_one_that_was_judged(tmp_path):
    trainer = trained(tmp_path, iterations=1)
    trainer.export(tmp_path)
    policy = load_policy(tmp_path / POLICY)
    assert policy.observations == trainer._env.observation_layout
    assert policy.times is not None
    assert (policy.robot, policy.env) == (trainer._task.robot, trainer._task.env)
    assert policy.facts["value"] == trainer._best["score"]["value"]
    assert trainer._selector.score(policy.network).value == trainer._best["score"]["value"]


def test_first_actions_are_small(tmp_path):
    trainer = Trainer(task(), job(tmp_path))
    network = trainer._network(actor(trainer))
    plain = Trainer(
        task(network=replace(config(*TINY).train.walking.network, output_scale=1.0)),
        job(tmp_path / "plain"),
    )
    observations = torch.randn(100, network.mean.numel())
    with torch.inference_mode():
        small, large = (
            t._network(actor(t)).mlp[-1].weight.abs().mean().item() for t in (trainer, plain)
        )
        assert network(observations).abs().max() < 0.5
    assert small == pytest.approx(task().train.network.output_scale * large, rel=1e-5)


def test_no_iterations_still_give_a_policy(tmp_path):
    trainer = trained(tmp_path, iterations=0)
    trainer.export(tmp_path)
    assert load_policy(tmp_path / POLICY).observations == trainer._env.observation_layout
    assert not (tmp_path / CURVE).exists(), "no curve of nothing"


def test_blow_ups_are_reported_outside_the_result(tmp_path):
    trainer = Trainer(task(iterations=1), job(tmp_path))
    trainer._env._physics.qvel[3, 6:] = 1e9
    trainer.run()
    assert trainer._job.volatile["blow_ups"] == 1


def test_trains_on_disturbed_robots_and_repeats_itself(tmp_path):
    """Uneven ground and late drives as well; another policy than without."""
    overrides = (
        "train/walking/disturbance=robust",
        "train.walking.disturbance.ground.amplitude=0.01",
    )
    rough = config(*TINY, *overrides).train.walking.disturbance
    one, again = (trained(tmp_path / name, disturbance=rough) for name in ("one", "again"))
    assert same(actor(one), actor(again))
    assert not same(actor(one), actor(trained(tmp_path / "calm")))
