"""Reflected samples are what a reflected robot would have seen and done."""

import numpy as np
import pytest
import torch
from tensordict import TensorDict

from slider.core.job import NoTracker
from slider.env.interface import FLOAT64
from slider.env.vec_env import Task
from slider.training.ppo import runner_config, with_reflections
from slider.training.trainer import Trainer
from tests.env.synthetic import PERMUTATION, SIGN, config, gait_table, make_guide, mirror_pose
from tests.training.test_trainer import TINY, Run, actor, job, same

UNMIRRORED = (*TINY, "env.phase.mirror=false")


def make_run(folder, *overrides: str) -> Run:
    whole, table = config(*UNMIRRORED, *overrides), gait_table()
    walking, made = whole.train.walking, job(folder)
    task = Task(whole.robot, whole.env, walking, table.times, make_guide(), table.joints)
    return Run(Trainer(task, made), made)


def test_reflections_follow_the_originals(tmp_path):
    """Half of the robots are put where the others are in a mirror, half a walk later."""
    env = make_run(tmp_path).trainer.env
    half = env.num_envs // 2
    index = np.arange(env.num_envs)
    pose = mirror_pose(env.physics.qpos[:half].copy(), env.physics.qvel[:half].copy())
    both = [
        np.concatenate([own[:half], other])
        for own, other in zip((env.physics.qpos, env.physics.qvel), pose, strict=True)
    ]
    env.physics.reset(index, *both)
    command = np.tile([0.4, 0.05, 0.1], (env.num_envs, 1))
    command[half:] *= [1, -1, -1]
    state = env.physics.read().tensors(FLOAT64)
    env.agent.set_velocity_command(index, torch.tensor(command))
    phase = torch.linspace(0.1, 0.4, half)
    env.agent.reset(index, state, torch.cat([phase, phase + 0.5]).double())
    env.agent.refresh_heading(state)
    values = env.agent.observe(state)
    seen = TensorDict({"policy": values}, batch_size=[env.num_envs])
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
    settings = runner_config(config(*TINY).train.walking, NoTracker(), [])
    assert settings["algorithm"]["symmetry_cfg"] is None


@pytest.mark.parametrize("kind", ["augmentation", "loss"])
def test_it_changes_what_is_learned(tmp_path, kind):
    plain, symmetric = (
        make_run(tmp_path / name, f"train.walking.ppo.symmetry={name}") for name in ("none", kind)
    )
    for run in (plain, symmetric):
        run.trainer.run()
    assert not same(actor(plain.trainer), actor(symmetric.trainer))
    losses = symmetric.notes.series("Loss/symmetry")
    assert [step for step, _ in losses] == symmetric.iterations
    assert all(np.isfinite(value) and value > 0 for _, value in losses)
    assert not plain.notes.series("Loss/symmetry")
