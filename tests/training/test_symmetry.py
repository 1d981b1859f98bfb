"""Reflected samples are what a reflected robot would have seen and done."""

import numpy as np
import pytest
import torch

from slider.training.symmetry import symmetry_config, with_reflections
from slider.training.task import Task
from slider.training.trainer import Trainer
from tests.env.synthetic import PERMUTATION, SIGN, config, gait_table, make_guide, mirror_pose
from tests.training.test_trainer import TINY, actor, job, same

UNMIRRORED = (*TINY, "env.phase.mirror=false")


def make_trainer(folder, *overrides: str) -> Trainer:
    whole = config(*UNMIRRORED, *overrides)
    times = gait_table().times
    joints = gait_table().joints
    task = Task(whole.robot, whole.env, whole.train.walking, times, make_guide(), joints)
    return Trainer(task, job(folder))


def test_reflections_follow_the_originals(tmp_path):
    """Half of the robots are put where the others are in a mirror, half a walk later."""
    env = make_trainer(tmp_path)._env
    half = env.num_envs // 2
    index = np.arange(env.num_envs)
    pose = mirror_pose(env._physics.qpos[:half].copy(), env._physics.qvel[:half].copy())
    both = [
        np.concatenate([own[:half], other])
        for own, other in zip((env._physics.qpos, env._physics.qvel), pose, strict=True)
    ]
    env._physics.reset(index, *both)
    command = np.tile([0.4, 0.05, 0.1], (env.num_envs, 1))
    command[half:] *= [1, -1, -1]
    env._agent.set_velocity_command(index, command)
    phase = np.linspace(0.1, 0.4, half)
    env._agent.reset(index, env._physics.read(), np.concatenate([phase, phase + 0.5]))
    env._agent.refresh_heading(env._physics.read())
    env._measured = env._physics.read()
    env._observe()
    seen = env.get_observations()
    action = torch.randn(half, 12)
    observations, actions = with_reflections(env, seen[:half], action)
    assert observations is not None
    assert actions is not None
    assert observations.batch_size == (2 * half,)
    assert torch.equal(observations["policy"][:half], seen["policy"][:half])
    np.testing.assert_allclose(observations["policy"], seen["policy"], atol=1e-5)
    np.testing.assert_allclose(actions[half:], action.numpy()[:, PERMUTATION] * SIGN, atol=1e-6)
    assert np.abs(observations["policy"][:half] - observations["policy"][half:]).max() > 0.1


def test_it_is_off_by_default():
    assert symmetry_config(config(*TINY).train.walking.ppo) is None


@pytest.mark.parametrize("kind", ["augmentation", "loss"])
def test_it_changes_what_is_learned(tmp_path, kind):
    trained = []
    for name in ("none", kind):
        trainer = make_trainer(tmp_path / name, f"train.walking.ppo.symmetry={name}")
        trainer.run()
        trained.append(trainer)
    assert not same(actor(trained[0]), actor(trained[1]))
    losses = trained[1]._job.tracker.series("Loss/symmetry")  # type: ignore
    assert len(losses) == trained[1]._task.train.iterations
    assert all(np.isfinite(value) and value > 0 for _, value in losses)
