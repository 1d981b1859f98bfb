"""Named quantities against MuJoCo's own sensors and bodies, and what counts as a fall."""

import mujoco
import numpy as np
import pytest

from slider.env import terminations
from slider.robot.kinematics import quaternion_from_tilt, rotation_from_quaternion
from slider.robot.names import NUM_JOINTS
from tests.env.synthetic import make_physics, make_state, random_pose

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


# Design, section 3: base z < 0.40 m, tilt > 45°, or a body other than a foot on the ground.
PROTOCOL = {"base_height": 0.4, "tilt": np.pi / 4, "body_contact": 0.0}


def test_height_and_contacts():
    base = [[0, 0, 0.399], [9, 9, 0.401], [0, 0, 2.0], [0, 0, 2.0]]
    state = make_state(4, base_position=base, body_contacts=[0, 0, 1, 2])
    np.testing.assert_array_equal(terminations.failed(state, PROTOCOL), [True, False, True, True])


def test_tilt_in_any_direction():
    roll = np.radians([44.9, 45.1, 0.0, 0.0, 33.0, 30.0, 180.0])
    pitch = np.radians([0.0, 0.0, -44.9, -45.1, 33.0, -30.0, 0.0])
    rotation = rotation_from_quaternion(quaternion_from_tilt(roll, pitch))
    state = make_state(7, gravity=-rotation[:, 2, :], rotation=rotation)
    expected = np.degrees(np.arccos(rotation[:, 2, 2])) > 45.0
    assert list(expected[:4]) == [False, True, False, True]
    np.testing.assert_array_equal(terminations.failed(state, PROTOCOL), expected)
