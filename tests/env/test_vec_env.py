"""Every variant of the environment builds, resets and steps, with agents that know nothing."""

import dataclasses
from dataclasses import replace

import numpy as np
import pytest
import torch

from slider.config.env import StartNoise
from slider.config.schema import Config
from slider.config.train import TrainConfig, VelocitiesConfig
from slider.config.types import Interval
from slider.env.guide import Guide
from slider.env.interface import FLOAT64
from slider.env.vec_env import Random, Task, VelocitySampler, WalkingEnv, task_of
from slider.library.reader import STORE
from tests.env.synthetic import TURNING, config, gait_table, make_guide
from tests.library.gaits import straight

TRAININGS = [(name, "walking") for name in ("default", "turning", "paper", "paper_alive")]
TRAININGS += [("default", "standing"), ("paper", "standing")]
NUM_ENVS = 6
STILL = torch.zeros(NUM_ENVS, 12)


def build(
    whole: Config, train: TrainConfig | None = None, guide: Guide | None = None
) -> WalkingEnv:
    train = replace(train or whole.train.walking, robots=NUM_ENVS, seed=0)
    table = gait_table()
    times = table.times if whole.env.phase.enabled else None
    guide = guide or make_guide()
    return WalkingEnv(Task(whole.robot, whole.env, train, times, guide, table.joints))


def actions(random: bool, generator: torch.Generator) -> torch.Tensor:
    return 3.0 * random * torch.randn(NUM_ENVS, 12, generator=generator)


@pytest.mark.parametrize(("experiment", "training"), TRAININGS)
def test_builds_resets_and_steps(experiment, training):
    whole = config(f"experiment={experiment}")
    train = getattr(whole.train, training)
    env = build(whole, train)
    size = sum(env.agent.observer.layout.values())
    assert env.get_observations()["policy"].shape == (NUM_ENVS, size)
    assert env.num_actions == 12
    generator, falls = torch.Generator().manual_seed(0), 0
    for step in range(50):
        observations, reward, done, extras = env.step(actions(step >= 10, generator))
        assert observations.batch_size == (NUM_ENVS,)
        assert observations["policy"].shape == (NUM_ENVS, size)
        assert observations["policy"].dtype == reward.dtype == torch.float32
        assert torch.isfinite(observations["policy"]).all()
        assert reward.shape == done.shape == extras["time_outs"].shape == (NUM_ENVS,)
        assert torch.isfinite(reward).all()
        assert ((env.episode_length_buf == 0) == done).all()
        falls += int(done.sum())
        logged = {name for name in extras["log"] if name.startswith("/reward/")}
        assert logged == {f"/reward/{name}" for name in train.reward.active}
        assert all(np.isfinite(value) for value in extras["log"].values())
    assert env.diverged == 0
    assert falls > 0, "a random agent falls within a second"


def test_a_fall_at_the_time_limit_is_no_time_out():
    env = build(config("experiment=test"))
    for _ in range(3):
        env.episode_length_buf[:] = env.max_episode_length - 1
        env.physics.qpos[:2, 2] = 0.2
        _, _, done, extras = env.step(STILL)
        assert done.all()
        assert extras["time_outs"].tolist() == [0, 0, 1, 1, 1, 1]


def test_episodes_end_at_their_length():
    whole = config("experiment=test")
    env = build(whole, replace(whole.train.standing, episode_length=0.2))
    assert env.max_episode_length == 10
    env.episode_length_buf = torch.tensor([0, 0, 0, 4, 4, 9])
    ended = []
    for _ in range(10):
        _, _, done, extras = env.step(STILL)
        np.testing.assert_array_equal(extras["time_outs"].numpy(), done.numpy())
        ended.append(done.numpy())
    when = np.argwhere(np.array(ended)).tolist()
    assert when == [[0, 5], [5, 3], [5, 4], [9, 0], [9, 1], [9, 2]]


def test_a_blow_up_ends_the_episode_and_is_counted():
    env = build(config("experiment=test"))
    env.step(STILL)
    env.physics.qvel[4, 6:] = 1e9
    observations, reward, done, extras = env.step(STILL)
    assert done[4] == 1
    assert extras["time_outs"][4] == 0
    assert extras["log"]["/episode/diverged"] == 1.0
    assert env.diverged == 1
    assert torch.isfinite(observations["policy"]).all()
    assert torch.isfinite(reward).all()
    _, _, done, extras = env.step(STILL)
    assert extras["log"]["/episode/diverged"] == 0.0
    assert done[4] == 0


def starting(whole: Config, share: float, guide: Guide | None = None, **velocities) -> WalkingEnv:
    """The walking training with a share of starts on the gait."""
    train = whole.train.walking
    velocities = replace(train.velocities, **velocities)
    reset = replace(train.reset, reference_fraction=share)
    return build(whole, replace(train, reset=reset, velocities=velocities), guide)


@pytest.mark.parametrize("share", [1.0, 0.0])
def test_starts_on_the_reference(share):
    """Episodes start on the gait at the clock's phase, or at rest in the nominal pose."""
    noise = [f"env.start.{item.name}=0.0" for item in dataclasses.fields(StartNoise)]
    env = starting(config("experiment=test", *noise), share)
    state, command = env.physics.read(), env.agent.command
    reference = share * gait_table().at(command[:, :3].numpy(), env.agent.clock.phase.numpy())
    np.testing.assert_allclose(state.joint_positions, reference[:, :12], atol=1e-9)
    np.testing.assert_allclose(state.joint_velocities, reference[:, 12:24], atol=1e-9)
    np.testing.assert_allclose(state.heading_velocity, reference[:, 24:26], atol=1e-9)
    np.testing.assert_allclose(env.agent.filtered_velocity, share * command[:, :2])
    assert not state.base_position[:, :2].any()


@pytest.mark.parametrize(("share", "expected"), [(0.0, True), (1.0, False)])
def test_robots_at_rest_with_a_zero_command_are_halted_and_those_on_the_gait_step(share, expected):
    whole = config("experiment=test", "env.phase.halt.below=0.2", "env.phase.halt.above=0.4")
    clock = starting(whole, share, standing_fraction=1.0).agent.clock
    np.testing.assert_array_equal(clock.halted, expected)
    assert (clock.phase == 0).all() == expected


def test_commands_are_seen_and_change():
    limits = Interval(0.1, 0.5)
    env = starting(config("experiment=test"), 0.0, period=0.2, vx=limits, standing_fraction=0.0)
    before = env.agent.command[:, :3].numpy().copy()
    for _ in range(40):
        env.step(STILL)
    after = env.agent.command[:, :3].numpy()
    assert (before != after).any(axis=1).mean() > 0.5
    assert ((after[:, 0] >= limits.lower) & (after[:, 0] <= limits.upper)).all()


def test_disturbances_spoil_what_the_agent_sees_and_not_the_start_of_the_others():
    """Same seed: commands, starts and phases are drawn alike with disturbances and without."""
    calm, rough = (
        build(config("experiment=test", *extra))
        for extra in ((), ("train/walking/disturbance=robust",))
    )
    np.testing.assert_array_equal(calm.physics.qpos, rough.physics.qpos)
    np.testing.assert_array_equal(calm.agent.command[:, :3], rough.agent.command[:, :3])
    error = (calm.get_observations()["policy"] - rough.get_observations()["policy"]).numpy()
    assert 0.0 < np.abs(error).max() < 1.0
    before = rough.physics.masses.copy()
    rough.physics.qpos[2, 2] = 0.2  # falls, and starts as another robot
    rough.step(STILL)
    np.testing.assert_array_equal(np.flatnonzero(rough.physics.masses != before), [2])


def test_robots_that_start_on_a_turning_gait_are_on_their_course():
    """The heading target is the course of the walk at the phase of the start."""
    guide = make_guide("interpolated", *TURNING)
    whole = config("experiment=test", "env.start.tilt=0")
    env = starting(whole, 1.0, guide, yaw_rate=Interval(-0.5, 0.5))
    command, yaw = env.agent.command, env.physics.read().yaw
    expected = guide.course(command[:, :3], env.agent.clock.phase).numpy()
    np.testing.assert_allclose(yaw, expected, atol=1e-4)  # attitudes are blended as quaternions
    np.testing.assert_allclose(command[:, 3], expected - yaw, atol=1e-9)
    assert np.ptp(yaw) > 0.05


def test_the_decrease_of_v_is_over_a_control_step_and_not_over_a_reset(monkeypatch):
    env = build(config("experiment=test", "train/walking/reward=clf"))
    reward, seen = env.reward, []
    monkeypatch.setattr(env, "reward", lambda r, fell: seen.append(r) or reward(r, fell))
    generator, before = torch.Generator().manual_seed(0), torch.full((NUM_ENVS, 2, 10), np.inf)
    for step in range(60):
        if step == 30:
            env.physics.qpos[2, 2] = 0.2  # falls
        _, _, done, _ = env.step(actions(True, generator))
        torch.testing.assert_close(seen[-1].outputs_before, before.double(), rtol=0, atol=0)
        before = seen[-1].outputs.where(done[:, None, None] == 0, np.inf)
        assert step != 30 or done[2]


@pytest.mark.parametrize("guided", [True, False])
@pytest.mark.parametrize(
    ("overrides", "times", "reference"),
    [
        (["env/phase=clock"], [0.42, 0.37], True),  # as the gaits were written
        (["env.phase.step_time=0.3", "env.action.offset=nominal"], [0.3, 0.3], False),
        (["env/phase=none", "env.action.offset=nominal"], None, False),
    ],
)
def test_the_task_has_what_the_configuration_asks_for(overrides, times, reference, guided):
    whole = config("experiment=test", *overrides)
    task = task_of(whole.robot, whole.env, whole.train.walking, straight() / STORE, guided)
    found = [part is not None for part in (task.guide, task.reference, task.times)]
    assert found == [guided, reference, times is not None]
    if times is not None:
        commands = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)])
        np.testing.assert_allclose(task.times.at(commands), times)


def test_terrain_grades_robots_and_slows_them():
    """Levels: up after an episode of a metre, down after a fall; half of the velocity off it."""
    terrain = "{kinds: [flat, tiles], level: {lower: 3, upper: 5}, curriculum: true}"
    values = (
        f"disturbance.terrain={terrain}",
        "velocities={uneven: 0.5, vx: {lower: 1.0, upper: 1.0}, standing_fraction: 0.0}",
        "episode_length=0.1",
    )
    whole = config(*(f"train.walking.{value}" for value in values))
    env = build(whole)
    np.testing.assert_allclose(env.agent.command[:, 0], [1.0, 0.5] * 3)
    levels = env.physics.terrain.levels
    levels[:] = 4.0
    env.physics.qpos[:4, 0] += 1.5  # these come further than a metre
    env.physics.qpos[4:, 2] -= 0.5  # these have fallen
    for _ in range(5):
        env.step(STILL)
    np.testing.assert_array_equal(levels[[1, 3]], 5.0)
    assert levels[5] == 3.0
    state = env.terrain_levels
    other = build(whole)
    other.restore_levels(state)
    np.testing.assert_array_equal(other.physics.terrain.levels, state)


def sampler(period: float = 5.0, standing: float = 0.25) -> VelocitySampler:
    ranges = (Interval(0.2, 3.0), Interval(-0.1, 0.3), Interval(-0.5, 0.5))
    config = VelocitiesConfig(*ranges, period, standing, uneven=1.0)
    return VelocitySampler(config, control_period=0.02, like=FLOAT64)


def test_uniform_within_the_ranges():
    commands = sampler(standing=0.0).sample(Random(0, FLOAT64), 20000).numpy()
    lower, upper = np.array([[0.2, -0.1, -0.5], [3.0, 0.3, 0.5]])
    assert ((commands >= lower) & (commands <= upper)).all()
    width = upper - lower
    np.testing.assert_allclose(commands.mean(axis=0), (lower + upper) / 2, atol=0.01 * width.max())
    np.testing.assert_allclose(commands.std(axis=0), width / np.sqrt(12), rtol=0.02)
    assert np.abs(np.corrcoef(commands.T) - np.eye(3)).max() < 0.03


@pytest.mark.parametrize(("period", "expected"), [(4.0, 5.0), (0.0, 0.0)])
def test_rate_of_change(period, expected):
    """In 20 s; never, at a period of zero."""
    changing, counts, rng = sampler(period).changing, np.zeros(500), Random(0, FLOAT64)
    for _ in range(1000):
        counts[changing(rng, 500)] += 1
    assert counts.mean() == pytest.approx(expected, rel=0.05)
    assert counts.var() == pytest.approx(expected, rel=0.25), "robots should change independently"
