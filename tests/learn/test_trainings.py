"""The shipped configuration, cut short, teaches robots that fall at once to stand and to walk."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from slider.control import POLICY_FILE
from slider.control.policy import PolicyController, agent_of, load_policy
from slider.env.guide import Guide
from slider.env.metrics import gait_quality, tracking
from slider.env.physics import BatchedPhysics
from slider.env.rollout import Recording, roll_out
from slider.env.starts import USUAL_NOISE, at_rest
from slider.env.vec_env import Task
from slider.library.lookup import GaitTable
from slider.library.reader import GaitLibrary
from slider.training.trainer import WEIGHTS, Trainer
from tests.env.synthetic import config
from tests.training.test_trainer import Run, job

GAITS = Path(__file__).parent / "gaits.npz"  # of the default library: 0 and 0.4 m/s, 0.32 s a step
SPEED, STEP_TIME = 0.4, 0.32  # [m/s], [s]
ROBOTS, SECONDS, SETTLED = 40, 4.0, 1.5
# Fewer robots and neurons, one command. Rewards, starts, disturbances and PPO are the default's.
SHORT = (
    "train.standing.robots=128",
    "train.standing.ppo.precision=float32",
    "train.standing.selection={interval: 25, robots: 20, duration: 3.0}",
    "train.walking.robots=64",
    "train.walking.ppo.precision=float32",
    "train.walking.network.hidden=[64,64]",
    f"train.walking.velocities.vx={{lower: {SPEED}, upper: {SPEED}}}",
    "train.walking.velocities.vy={lower: 0.0, upper: 0.0}",
    "train.walking.velocities.standing_fraction=0.0",
    f"train.walking.selection={{interval: 50, speeds: [{SPEED}], robots: 20, duration: 3.0}}",
    "finetuning=outdoor",
    "finetuning.robots=60",
    "finetuning.velocities.uneven=1.0",
    "finetuning.disturbance.push.impulse.upper=0.0",
    "finetuning.ppo.precision=float32",
    "finetuning.selection={interval: 50, robots: 1, duration: 3.0}",
)


def train(folder: Path, training: str, iterations: int, start: Path | None = None) -> Run:
    """A training, from the weights in a folder if there is one, with its policy in ``folder``."""
    whole = config(*SHORT, f"{training}.iterations={iterations}")
    with np.load(GAITS) as arrays:
        library = GaitLibrary({name: arrays[name].astype(float) for name in arrays}, {})
    table = GaitTable.from_library(library)
    settings = whole.trainings[training]
    guide = None
    if training != "train.standing":
        guide = Guide(library, table, whole.robot.geometry, settings.guide.gait)
    made = job(folder)
    env = replace(whole.env, sensing=settings.sensing)
    task = Task(whole.robot, env, settings, table.times, guide, table.joints)
    run = Run(Trainer(task, made), made)
    if start is not None:
        run.trainer.start_from(start / WEIGHTS)
    run.trainer.run()
    run.trainer.export(folder)
    return run


def roll(folder: Path, speed: float) -> Recording:
    """The exported policy, from rest."""
    policy = load_policy(folder / POLICY_FILE)
    physics = BatchedPhysics(policy.robot, policy.env.physics, ROBOTS)
    controller = PolicyController(
        policy.network, agent_of(policy, policy.robot, policy.env, ROBOTS)
    )
    start = at_rest(policy.robot, USUAL_NOISE, np.random.default_rng(7), ROBOTS)
    command = np.tile([speed, 0.0, 0.0], (ROBOTS, 1))
    return roll_out(controller, physics, policy.env, start, command, SECONDS)


def falls(run: Run) -> np.ndarray:
    """Falls per second in each iteration."""
    return np.array([value for _, value in run.notes.series("episode/falls_per_second")])


@pytest.mark.learn
def test_standing_is_learned(tmp_path):
    rate = falls(train(tmp_path, "train.standing", 60))
    assert rate[-10:].mean() < 0.6 * rate[1:11].mean()


@pytest.fixture(scope="module")
def walked(tmp_path_factory) -> tuple[Path, Run]:
    """A walking training, and its folder."""
    folder = tmp_path_factory.mktemp("walked")
    return folder, train(folder, "train.walking", 300)


@pytest.mark.learn
def test_walking_is_learned_in_a_minute(walked):
    """Without a pre-trained policy. Bounds are about twice the worst of three seeds."""
    folder, run = walked
    rate, recording = falls(run), roll(folder, SPEED)
    tracked, quality = tracking(recording, SETTLED, 0.1, 0.1), gait_quality(recording, SETTLED)
    assert tracked["survived"].mean() >= 0.9
    assert np.nanmean(tracked["mean_velocity"]) == pytest.approx(SPEED, abs=0.04)
    assert np.nanmean(tracked["squared_error_steady"]) < 0.004
    assert np.nanmean(quality["touchdown_rate"]) == pytest.approx(1 / STEP_TIME, rel=0.03)
    assert np.nanmean(quality["alternation"]) > 0.98
    assert np.nanmean(quality["flight"]) < 0.005
    assert np.nanmean(quality["double_support"]) < 0.2
    assert np.nanmean(quality["clearance"]) > 0.05
    assert np.nanmean(quality["heading"]) < 0.5
    assert rate[-20:].mean() < 0.2 * rate[1:21].mean()


@pytest.mark.learn
def test_terrain_is_learned_from_a_walk(walked, tmp_path):
    """In six episodes, of robots that are not pushed."""
    run = train(tmp_path, "finetuning", 60, start=walked[0])
    levels = np.array([value for _, value in run.notes.series("episode/terrain_level")])
    assert levels[0] < 0.5
    assert levels[-5:].mean() > 1.2
