"""The training environment behind Gymnasium's interfaces."""

import gymnasium
import numpy as np
import pytest
import torch
from gymnasium.utils.env_checker import check_env

from slider.core.errors import UserError
from slider.env.vec_env import WalkingEnv
from slider.library.reader import STORE
from tests.library.gaits import straight

NAME = "slider.gym:slider/Walking-v0"
STEPS = 60


def test_one_robot_passes_gymnasiums_check():
    env = gymnasium.make(NAME, library=straight() / STORE)
    check_env(env.unwrapped, skip_render_check=True)


def test_many_robots_are_those_of_the_training():
    envs = gymnasium.make_vec(NAME, num_envs=3, library=straight() / STORE)
    first, _ = envs.reset(seed=7)
    plain = WalkingEnv(envs.unwrapped.task)  # pyright: ignore[reportAttributeAccessIssue]
    np.testing.assert_array_equal(first, plain.get_observations()["policy"])
    generator, fell = np.random.default_rng(0), 0
    for _ in range(STEPS):
        actions = generator.uniform(-1, 1, (3, 12)).astype(np.float32)
        seen, reward, terminated, truncated, info = envs.step(actions)
        observations, expected, done, extras = plain.step(torch.as_tensor(actions))
        np.testing.assert_array_equal(seen, observations["policy"])
        np.testing.assert_array_equal(reward, expected)
        np.testing.assert_array_equal(terminated | truncated, done)
        np.testing.assert_array_equal(truncated, extras["time_outs"])
        for index in np.flatnonzero(terminated):
            last = info["final_obs"][index]
            assert envs.single_observation_space.contains(last)
            assert abs(last - seen[index]).max() > 0.1, "the robot of before, not the new one"
        fell += terminated.sum()
    assert fell > 0, "a random agent falls"


def test_an_episode_ends_by_its_length_and_starts_again():
    short = ["train.walking.episode_length=0.1"]
    env = gymnasium.make(NAME, library=straight() / STORE, overrides=short)
    env.reset(seed=1)
    last, _, *ends, _ = [env.step(np.zeros(12, np.float32)) for _ in range(5)][-1]
    assert ends == [False, True]
    assert abs(env.reset()[0] - last).max() > 1e-3


@pytest.mark.parametrize("change", ["experiment=robust", "train.walking.sensing=onboard"])
def test_overrides_of_the_training_act_on_the_robot(change):
    """A fine-tuning's disturbances, and the state that is estimated on board."""

    def seen(*overrides: str) -> np.ndarray:
        env = gymnasium.make(NAME, library=straight() / STORE, overrides=overrides)
        env.reset(seed=1)
        return [env.step(np.zeros(12, np.float32))[0] for _ in range(3)][-1]

    assert abs(seen(change) - seen()).max() > 1e-4


def test_without_gaits_says_how_to_make_them(tmp_path):
    with pytest.raises(UserError, match="snakemake -j2 gait_library"):
        gymnasium.make(NAME, artefacts=tmp_path)
