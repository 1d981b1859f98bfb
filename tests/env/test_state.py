"""Frames and signs of the named quantities, against MuJoCo's own sensors and bodies."""

import mujoco
import numpy as np
import pytest

from slider.robot.names import NUM_JOINTS
from tests.env.synthetic import make_physics, random_pose

COUNT = 8


@pytest.fixture
def poses():
    return random_pose(np.random.default_rng(3), COUNT)


@pytest.fixture
def datas(poses):
    """MuJoCo's forward passes of robots tilted, turned and moving."""
    model, found = make_physics(1).model, []
    for qpos, qvel in zip(*poses, strict=True):
        found.append(mujoco.MjData(model))
        found[-1].qpos[:], found[-1].qvel[:] = qpos, qvel
        mujoco.mj_forward(model, found[-1])
    return found


def test_the_base_is_that_of_imu_and_body_and_its_heading_along_the_nose(poses, datas):
    physics = make_physics(COUNT)
    physics.reset(np.arange(COUNT), *poses)
    state = physics.read()
    for quantity, sensor in (("linear_velocity", "linear"), ("angular_velocity", "angular")):
        found = [data.sensor(f"base_{sensor}_velocity").data for data in datas]
        np.testing.assert_allclose(getattr(state, quantity), found, atol=1e-12)
    rotation = np.stack([data.body("base").xmat.reshape(3, 3) for data in datas])
    np.testing.assert_allclose(state.rotation, rotation, atol=1e-12)
    np.testing.assert_allclose(state.gravity, [r.T @ [0, 0, -1] for r in rotation], atol=1e-12)
    assert np.ptp(state.gravity[:, 0]) > 0.2, "no tilt: the comparison would prove little"
    nose = rotation[:, :2, 0] / np.linalg.norm(rotation[:, :2, 0], axis=1, keepdims=True)
    np.testing.assert_allclose(np.stack([np.cos(state.yaw), np.sin(state.yaw)], 1), nose)
    left = nose[:, ::-1] * [-1, 1]
    expected = [[q[:2] @ n, q[:2] @ m] for q, n, m in zip(poses[1], nose, left, strict=True)]
    np.testing.assert_allclose(state.heading_velocity, expected, atol=1e-12)
    for found, given in zip((state.qpos, state.qvel), poses, strict=True):
        np.testing.assert_allclose(found, given, atol=1e-12)


def test_sole_positions_and_velocities(poses, datas):
    physics = make_physics(COUNT, substeps=1, timestep=1e-4)  # sensors are those before the step
    physics.reset(np.arange(COUNT), *poses)
    physics.step(np.zeros((COUNT, NUM_JOINTS)))
    first = physics.read()
    soles = [[d.site(f"{side}_sole").xpos for side in ("left", "right")] for d in datas]
    np.testing.assert_allclose(first.foot_positions, soles, atol=1e-12)
    physics.step(np.zeros((COUNT, NUM_JOINTS)))
    second = physics.read()
    moved = (second.foot_positions - first.foot_positions) / 1e-4
    # Semi-implicit integration moves with the new velocity.
    np.testing.assert_allclose(moved, second.foot_velocities, atol=1e-3)
