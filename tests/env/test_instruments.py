"""Heels, toes and legs against kinematics, Jacobians and contacts; bounces and loads by hand."""

# pyright: reportAttributeAccessIssue=false

import mujoco
import numpy as np
import pytest

from slider.env.height_field import FLAT
from slider.env.instruments import (
    CONTACT_FORCE,
    LIFT_TIME,
    TOUCH_TIME,
    DriveLoads,
    loads,
    observe,
    over,
    touchdowns,
)
from slider.env.physics import BatchedPhysics
from slider.robot import names
from slider.robot.kinematics import foot_ends, rotation_from_quaternion
from slider.robot.mjcf import DISTANCE_CUTOFF, nominal_qpos
from slider.robot.names import JOINTS, NUM_JOINTS
from slider.robot.transmission import Transmission
from tests.env.synthetic import (
    SPEED_LIMITS,
    TORQUE_LIMITS,
    config,
    make_physics,
    random_pose,
    robot_config,
)

COUNT = 5
TIMESTEP, TICKS = 0.005, 100  # of forces made by hand [s], [-]


def placed(qpos: np.ndarray, qvel: np.ndarray | None = None, **settings: float) -> BatchedPhysics:
    """After one step; the sensors of its first simulation step are those of the pose."""
    physics = make_physics(len(qpos), **settings)
    still = np.zeros((len(qpos), 6 + NUM_JOINTS))
    physics.reset(np.arange(len(qpos)), qpos, still if qvel is None else qvel)
    physics.step(qpos[:, 7:])
    return physics


def posed(**joints: float) -> np.ndarray:
    """Nominal pose (1, 19), 0.2 m above the ground, with some joints elsewhere."""
    qpos = nominal_qpos(robot_config())[None].copy()
    qpos[:, 2] += 0.2
    for name, value in joints.items():
        qpos[:, 7 + JOINTS.index(name)] = value
    return qpos


def test_heels_and_toes_are_where_kinematics_says():
    qpos, qvel = random_pose(np.random.default_rng(0), COUNT)
    positions, _ = placed(qpos, qvel).foot_ends()
    rotation = rotation_from_quaternion(qpos[:, 3:7])
    expected = foot_ends(robot_config().geometry, rotation, qpos[:, 7:])
    expected += qpos[:, None, None, :3]
    np.testing.assert_allclose(positions[:, 0], expected, atol=1e-9)


def test_they_move_as_the_foots_material_does_there():
    """Against the Jacobian of the point."""
    qpos, qvel = random_pose(np.random.default_rng(1), COUNT)
    physics = placed(qpos, qvel)
    positions, velocities = physics.foot_ends()
    data, jacobian = mujoco.MjData(physics.model), np.zeros((3, physics.model.nv))
    for robot, foot, end in np.ndindex(COUNT, 2, 2):
        data.qpos[:], data.qvel[:] = qpos[robot], qvel[robot]
        mujoco.mj_forward(physics.model, data)
        body = physics.model.body(names.foot(names.SIDES[foot])).id
        point = positions[robot, 0, foot, end]
        mujoco.mj_jac(physics.model, data, jacobian, None, point, body)
        np.testing.assert_allclose(
            velocities[robot, 0, foot, end], jacobian @ qvel[robot], atol=1e-9
        )


def test_distance_of_legs_by_closed_forms():
    """Hip and tube in the nominal pose; soles where the legs lean inwards; and far apart."""
    geometry, angle = robot_config().geometry, 0.1
    between = 2 * geometry.hip[1]
    beside = between - geometry.hip_radius - geometry.tube_radius
    reach = geometry.leg_length + geometry.ankle_height - geometry.foot_radius
    soles = between - 2 * reach * np.sin(angle) - 2 * geometry.foot_radius
    inwards = posed(left_hip_roll=-angle, right_hip_roll=angle)
    found = placed(np.concatenate([posed(), inwards])).contacts().leg_distance[0]
    np.testing.assert_allclose(found, [beside, soles], atol=1e-6)
    assert soles < beside < DISTANCE_CUTOFF


def test_instruments_change_no_motion():
    start = random_pose(np.random.default_rng(3), COUNT)
    bare = BatchedPhysics(
        robot_config(), config("experiment=test").env.physics, COUNT, instruments=False
    )
    whole = make_physics(COUNT)
    for physics in (bare, whole):
        physics.reset(np.arange(COUNT), *start)
        for _ in range(10):
            physics.step(np.zeros((COUNT, NUM_JOINTS)))
    np.testing.assert_array_equal(bare.qpos, whole.qpos)
    for name, value in vars(bare.read()).items():
        np.testing.assert_array_equal(value, getattr(whole.read(), name), err_msg=name)


def left_foot(*spans: tuple[int, int]) -> np.ndarray:
    """Forces (TICKS, 1, 2) of a left foot that is down from the first to before the second."""
    forces = np.zeros((TICKS, 1, 2))
    for start, stop in spans:
        forces[start:stop, 0, 0] = 50.0
    return forces


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
    assert (LIFT_TIME, TOUCH_TIME) == (0.03, 0.02), "the spans are for these"
    found = touchdowns(left_foot(*spans), TIMESTEP)
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
    found = feet([[2e-3, 1e-3], [-1e-3, -2e-3]], [50.0, CONTACT_FORCE])
    assert found.loaded[0, 0].tolist() == [[False, True], [False, False]]
    np.testing.assert_allclose(found.speeds, 0.5, rtol=1e-6)
    np.testing.assert_allclose(found.leg_distance, [[0.1]], rtol=1e-6)


def test_loads_by_hand():
    """Two simulation steps of one robot: one motor drives, another one brakes."""
    torques, speeds = np.zeros((2, 1, 2, 10))
    torques[0, :, 0], speeds[0, :, 0] = [8.0, -4.0], [3.0, 3.0]
    torques[0, :, 1], speeds[0, :, 1] = [-6.0, 0.0], [2.0, -5.0]
    found = loads(Transmission.of(robot_config()), torques, speeds)
    assert found.power == pytest.approx((24.0 + 12.0 + 12.0) / 2)
    assert found.effort_share == pytest.approx(max(8.0 / TORQUE_LIMITS[0], 6.0 / TORQUE_LIMITS[1]))
    assert found.speed_share == pytest.approx(max(3.0 / SPEED_LIMITS[0], 5.0 / SPEED_LIMITS[1]))


def test_loads_over_time_are_a_mean_power_and_peaks():
    rows = [([10.0, 0.0], [0.2, 0.9], [0.5, 0.1]), ([20.0, 4.0], [0.4, 0.3], [0.3, 0.2])]
    found = over([DriveLoads(*(np.array(values) for values in row)) for row in rows])
    assert [values.tolist() for values in found] == [[15.0, 2.0], [0.4, 0.9], [0.5, 0.2]]
