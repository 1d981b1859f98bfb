"""Frames and signs of the named quantities, against MuJoCo's own sensors and bodies."""

# pyright: reportAttributeAccessIssue=false

import mujoco
import numpy as np
import pytest

from slider.robot.names import NUM_JOINTS
from tests.env.synthetic import make_physics, random_pose

COUNT = 8


@pytest.fixture
def posed():
    """Robots tilted, turned and moving: the physics and MuJoCo's forward pass of each."""
    rng = np.random.default_rng(3)
    qpos, qvel = random_pose(rng, COUNT)
    physics = make_physics(COUNT)
    physics.reset(np.arange(COUNT), qpos, qvel)
    datas = []
    for i in range(COUNT):
        data = mujoco.MjData(physics.model)
        data.qpos[:], data.qvel[:] = qpos[i], qvel[i]
        mujoco.mj_forward(physics.model, data)
        datas.append(data)
    return physics, datas


def test_base_velocities_are_those_of_the_imu(posed):
    physics, datas = posed
    state = physics.read()
    linear = [data.sensor("base_linear_velocity").data for data in datas]
    angular = [data.sensor("base_angular_velocity").data for data in datas]
    np.testing.assert_allclose(state.linear_velocity, linear, atol=1e-12)
    np.testing.assert_allclose(state.angular_velocity, angular, atol=1e-12)


def test_rotation_and_gravity(posed):
    physics, datas = posed
    state = physics.read()
    rotation = np.stack([data.body("base").xmat.reshape(3, 3) for data in datas])
    np.testing.assert_allclose(state.rotation, rotation, atol=1e-12)
    np.testing.assert_allclose(state.gravity, [r.T @ [0, 0, -1] for r in rotation], atol=1e-12)
    assert np.ptp(state.gravity[:, 0]) > 0.2, "no tilt: the comparison would prove little"


def test_heading_velocity_is_level_and_along_the_nose(posed):
    physics, datas = posed
    state = physics.read()
    for i, data in enumerate(datas):
        nose = data.body("base").xmat.reshape(3, 3)[:2, 0]
        nose = nose / np.linalg.norm(nose)
        left = np.array([-nose[1], nose[0]])
        velocity = data.qvel[:2]
        expected = [velocity @ nose, velocity @ left]
        np.testing.assert_allclose(state.heading_velocity[i], expected, atol=1e-12)
        np.testing.assert_allclose([np.cos(state.yaw[i]), np.sin(state.yaw[i])], nose, atol=1e-12)


def test_sole_positions_and_velocities(posed):
    _, datas = posed
    physics = make_physics(COUNT, substeps=1, timestep=1e-4)  # sensors are those before the step
    qpos, qvel = (np.stack([getattr(d, name) for d in datas]) for name in ("qpos", "qvel"))
    physics.reset(np.arange(COUNT), qpos, qvel)
    physics.step(np.zeros((COUNT, NUM_JOINTS)))
    first = physics.read()
    soles = [[d.site(f"{side}_sole").xpos for side in ("left", "right")] for d in datas]
    np.testing.assert_allclose(first.foot_positions, soles, atol=1e-12)
    physics.step(np.zeros((COUNT, NUM_JOINTS)))
    second = physics.read()
    moved = (second.foot_positions - first.foot_positions) / 1e-4
    # Semi-implicit integration moves with the new velocity.
    np.testing.assert_allclose(moved, second.foot_velocities, atol=1e-3)
