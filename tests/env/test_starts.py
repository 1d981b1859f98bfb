"""Starts touch the ground, have the asked noise and stay within the joints' limits."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
import torch

from slider.config.env import StartNoise
from slider.env.starts import at_rest, perturb, sample_about
from slider.robot.kinematics import foot_ends, rotation_from_quaternion
from slider.robot.mjcf import nominal_qpos
from tests.env.synthetic import JOINTS, config, make_guide, make_physics, robot_config

PROTOCOL = StartNoise(0.02, 0.005, 0.03, 0.0, 0.0, 0.0)
MOVING = StartNoise(0.02, 0.005, 0.03, 0.05, 0.1, 0.2)
SLIDES = np.array([name.endswith("slide") for name in JOINTS])


def start(noise: StartNoise, count: int = 4000, seed: int = 0):
    return at_rest(robot_config(), noise, np.random.default_rng(seed), count)


def test_mujoco_agrees_that_the_feet_just_touch():
    model = make_physics(1).model
    data = mujoco.MjData(model)
    qpos, _ = start(replace(PROTOCOL, joint_position=0.1, tilt=0.1), 20)
    feet = [model.geom(f"{side}_foot").id for side in ("left", "right")]
    for pose in qpos:
        data.qpos[:] = pose
        mujoco.mj_forward(model, data)
        gaps = [mujoco.mj_geomDistance(model, data, 0, foot, 10.0, None) for foot in feet]
        assert min(gaps) == pytest.approx(0.0, abs=1e-9)


def lowest(qpos: np.ndarray) -> np.ndarray:
    """Height of the lowest foot point above the ground [m]."""
    rotation = rotation_from_quaternion(qpos[:, 3:7])
    ends = foot_ends(robot_config().geometry, rotation, qpos[:, 7:])
    return ends[..., 2].min(axis=(1, 2)) + qpos[:, 2]


def on_gaits(count: int) -> tuple[np.ndarray, np.ndarray]:
    """States of gaits whose base is so high that the stance foot is on the ground."""
    draw = np.random.default_rng(3)
    command = draw.uniform(0.0, 0.4, (count, 1)) * [1.0, 0.0, 0.0]
    phase = torch.from_numpy(draw.uniform(size=count))
    states = make_guide().states(torch.from_numpy(command), phase)
    qpos, qvel = (values.numpy() for values in states)
    qpos[:, 2] -= lowest(qpos)
    return qpos, qvel


def test_noise_about_a_gait_puts_no_foot_into_the_ground():
    states = on_gaits(4000)
    noise = config("experiment=default").env.start
    qpos, qvel = sample_about(states, robot_config(), noise, np.random.default_rng(0))
    assert (lowest(qpos) < -0.001).mean() == 0.0
    assert lowest(qpos).min() > -1e-12
    plain_qpos, plain_qvel = (values.copy() for values in states)
    perturb(plain_qpos, plain_qvel, robot_config(), noise, np.random.default_rng(0))
    assert (lowest(plain_qpos) < -0.001).mean() > 0.2, "the noise does push feet into the ground"
    np.testing.assert_array_equal(qvel, plain_qvel)
    assert (lowest(plain_qpos) > 0.0).mean() > 0.2, "and leaves others above it"
    lifted, deep = qpos - plain_qpos, np.maximum(0.0, -lowest(plain_qpos))
    np.testing.assert_array_equal(lifted[deep == 0.0], 0.0)
    np.testing.assert_allclose(lifted[:, 2], deep, atol=1e-12)
    assert not np.delete(lifted, 2, axis=1).any()


def test_noise_has_the_asked_spread():
    qpos, qvel = start(MOVING)
    joints = qpos[:, 7:]
    np.testing.assert_allclose(joints.std(axis=0), np.where(SLIDES, 0.005, 0.02), rtol=0.06)
    np.testing.assert_allclose(np.abs(joints.mean(axis=0)).max(), 0.0, atol=0.002)
    gravity = -rotation_from_quaternion(qpos[:, 3:7])[:, 2, :]
    np.testing.assert_allclose(gravity[:, :2].std(axis=0), 0.03, rtol=0.06)
    spread = np.array([0.05] * 3 + [0.1] * 3 + [0.2] * 12)
    spread[6:][SLIDES] = 0.04
    np.testing.assert_allclose(qvel.std(axis=0), spread, rtol=0.06)
    np.testing.assert_allclose(np.linalg.norm(qpos[:, 3:7], axis=1), 1.0, atol=1e-12)
    assert not qpos[:, :2].any()
    joints = start(replace(PROTOCOL, joint_position=2.0, slide_position=1.0), 500)[0][:, 7:]
    lower, upper = robot_config().joint_ranges
    assert ((joints >= lower) & (joints <= upper)).all()
    assert (joints == upper).any()


def test_perturb_turns_the_base_about_its_own_axes():
    """Noise on a turned base tilts it by as much as on one that looks ahead."""
    qpos = np.tile(nominal_qpos(robot_config()), (2000, 1))
    qpos[:, 3:7] = np.cos(0.6), 0.0, 0.0, np.sin(0.6)
    perturb(qpos, np.zeros((2000, 18)), robot_config(), PROTOCOL, np.random.default_rng(0))
    rotation = rotation_from_quaternion(qpos[:, 3:7])
    np.testing.assert_allclose((-rotation[:, 2, :2]).std(axis=0), 0.03, rtol=0.08)
    np.testing.assert_allclose(np.arctan2(rotation[:, 1, 0], rotation[:, 0, 0]), 1.2, atol=0.01)
