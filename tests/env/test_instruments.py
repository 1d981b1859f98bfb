"""Heels, toes and legs against kinematics, Jacobians and contacts; bounces by hand."""

import mujoco
import numpy as np
import pytest

from slider.env.height_field import FLAT
from slider.env.instruments import CONTACT_FORCE, in_contact, landings, observe
from slider.env.physics import BatchedPhysics
from slider.robot import names
from slider.robot.kinematics import foot_ends, rotation_from_quaternion
from slider.robot.mjcf import DISTANCE_CUTOFF, nominal_qpos
from tests.env.synthetic import JOINTS, config, make_physics, random_pose, robot_config, stand

COUNT = 5


def placed(qpos: np.ndarray, qvel: np.ndarray) -> BatchedPhysics:
    """After one step; the sensors of its first simulation step are those of the pose."""
    physics = make_physics(len(qpos))
    physics.reset(np.arange(len(qpos)), qpos, qvel)
    physics.step(qpos[:, 7:])
    return physics


def test_heels_and_toes_are_where_kinematics_says_and_move_as_the_foots_material_there():
    """Against the Jacobian of the point."""
    qpos, qvel = random_pose(np.random.default_rng(1), COUNT)
    physics = placed(qpos, qvel)
    positions, velocities = physics.foot_ends()
    rotation = rotation_from_quaternion(qpos[:, 3:7])
    expected = foot_ends(robot_config().geometry, rotation, qpos[:, 7:]) + qpos[:, None, None, :3]
    np.testing.assert_allclose(positions[:, 0], expected, atol=1e-9)
    data, jacobian = mujoco.MjData(physics.model), np.zeros((3, physics.model.nv))
    for robot, foot, end in np.ndindex(COUNT, 2, 2):
        data.qpos[:], data.qvel[:] = qpos[robot], qvel[robot]
        mujoco.mj_forward(physics.model, data)
        body = physics.model.body(names.foot(names.SIDES[foot])).id
        mujoco.mj_jac(physics.model, data, jacobian, None, positions[robot, 0, foot, end], body)
        found = velocities[robot, 0, foot, end]
        np.testing.assert_allclose(found, jacobian @ qvel[robot], atol=1e-9)


def test_distance_of_legs_by_closed_forms():
    """Hip and tube in the nominal pose; soles where the legs lean inwards; and far apart."""
    geometry, angle = robot_config().geometry, 0.1
    between = 2 * geometry.hip[1]
    beside = between - geometry.hip_radius - geometry.tube_radius
    reach = geometry.leg_length + geometry.ankle_height - geometry.foot_radius
    soles = between - 2 * reach * np.sin(angle) - 2 * geometry.foot_radius
    qpos = np.tile(nominal_qpos(robot_config()), (2, 1))
    qpos[:, 2] += 0.2
    qpos[1, 7 + JOINTS.index("left_hip_roll")] = -angle
    qpos[1, 7 + JOINTS.index("right_hip_roll")] = angle
    found = placed(qpos, np.zeros((2, 18))).contacts().leg_distance[0]
    np.testing.assert_allclose(found, [beside, soles], atol=1e-6)
    assert soles < beside < DISTANCE_CUTOFF


def test_instruments_change_no_motion():
    settings, whole = config("experiment=test").env.physics, make_physics(COUNT)
    bare = BatchedPhysics(robot_config(), settings, COUNT, instruments=False)
    for physics in (bare, whole):
        stand(physics, 0.2)
    np.testing.assert_array_equal(bare.qpos, whole.qpos)
    for name, value in vars(bare.read()).items():
        np.testing.assert_array_equal(value, getattr(whole.read(), name), err_msg=name)


@pytest.mark.parametrize(
    ("spans", "expected"),
    [
        ([(20, 60)], [20]),
        ([(0, 30), (50, 80)], [50]),  # down at first
        ([(20, 25), (30, 60)], [20]),  # up for 25 ms
        ([(20, 25), (31, 60)], [20, 31]),  # up for 30 ms
        ([(20, 22), (24, 25), (27, 29), (30, 60)], [20]),  # rattles as it lands
        ([(20, 23), (60, 80)], [60]),  # grazes the ground for 15 ms
        ([(20, 24), (60, 80)], [20, 60]),  # 20 ms
        ([(20, 60), (98, 100)], [20, 98]),  # for how long, nobody knows
        ([(0, 100)], []),
    ],
)
def test_touchdowns_without_bounces(spans, expected):
    forces = np.zeros((100, 1, 2))
    for start, stop in spans:  # in which the left foot is down
        forces[start:stop, 0, 0] = 50.0
    found = landings(in_contact(forces, 0.005))
    assert np.flatnonzero(found[:, 0, 0]).tolist() == expected
    assert not found[:, 0, 1].any()


def feet(heights: list[list[float]], forces: list[float]):
    """Contacts of one robot in one step, of heights (foot, end) [m] and forces [N]."""
    ends = np.zeros((1, 1, 2, 2, 3))
    ends[..., 2] = heights
    velocities = np.tile([0.3, -0.4, 9.0], (1, 1, 2, 2, 1))
    return observe(np.array([[forces]]), ends, velocities, np.array([[[0.2, 0.1, 0.3]]]), FLAT)


def test_loaded_ends_are_those_that_sank_in_or_the_lower_one():
    found = feet([[-1e-3, 1e-3], [-1e-3, -2e-3]], [50.0, 50.0])
    assert found.loaded[0, 0].tolist() == [[True, False], [True, True]]
    np.testing.assert_allclose(found.depths[0, 0], [1e-3, 2e-3], rtol=1e-6)
    found = feet([[2e-3, 1e-3], [-1e-3, -2e-3]], [50.0, CONTACT_FORCE])
    assert found.loaded[0, 0].tolist() == [[False, True], [False, False]]
    np.testing.assert_allclose(found.speeds, 0.5, rtol=1e-6)
    np.testing.assert_allclose(found.leg_distance, [[0.1]], rtol=1e-6)
