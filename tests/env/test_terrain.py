"""Uneven ground: the same for MuJoCo, for feet, scan, starts, heights and terminations."""

# pyright: reportAttributeAccessIssue=false

from dataclasses import replace

import mujoco
import numpy as np

from slider.env import terminations
from slider.env.interface import FLOAT64
from slider.env.observations import base_height, height_scan
from slider.env.terrain import FLAT, SKIN, UnevenGround
from slider.robot import names
from slider.robot.kinematics import foot_ends
from tests.env.synthetic import disturbed_physics, make_arrays, make_view, robot_config, stand

AMPLITUDE = 0.03
SETTING = f"ground.amplitude={AMPLITUDE}"
COUNT = 30


def ramp(count: int, slope: float = 0.1) -> UnevenGround:
    """Rises with x, as long as nobody walks further than 50 m."""
    tile = np.tile(slope * np.arange(100.0), (100, 1))
    return UnevenGround(tile, 1.0, np.zeros((count, 2)))


def offsets(physics) -> np.ndarray:
    """Places in the world minus those on the height field (N, 2) [m]."""
    return physics.read().base_position[:, :2] - physics.qpos[:, :2]


def test_heights_are_those_of_mujocos_height_field():
    physics = stand(disturbed_physics(1, SETTING))
    ground = physics.read().ground
    offset = offsets(physics)[0]
    model = physics.model
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    group, found = np.array([1, 0, 0, 0, 0, 0], dtype=np.uint8), np.zeros(1, dtype=np.int32)
    model.geom_group[:] = 1
    model.geom(names.FLOOR).group = 0
    for place in np.random.default_rng(0).uniform(-1.4, 5.4, (200, 2)):
        above, down = np.array([*place, 2.0]), np.array([0.0, 0.0, -1.0])
        distance = mujoco.mj_ray(model, data, above, down, group, 1, -1, found, None)
        here = ground.height((place + offset)[None])[0]
        assert abs(2.0 - distance + SKIN - here) < 1e-6
        assert abs(here) <= AMPLITUDE


def lowest_clearance(state) -> np.ndarray:
    """Of heel and toe of both feet above the ground (N,) [m]."""
    ends = foot_ends(robot_config().geometry, state.rotation, state.joint_positions)
    points = (ends + state.base_position[:, None, None]).reshape(state.num_robots, 4, 3)
    return (points[..., 2] - state.ground.height(points[..., :2])).min(axis=1)


def test_a_start_touches_the_ground_and_the_feet_carry_the_robot():
    physics = stand(disturbed_physics(COUNT, SETTING))
    state = physics.read()
    clearance = lowest_clearance(state)
    assert (clearance > -1e-9).all()
    assert (clearance < 2 * AMPLITUDE).all()
    assert np.ptp(state.base_position[:, 2]) > AMPLITUDE, "not all on one height"
    np.testing.assert_allclose(state.base_position[:, :2], 0.0, atol=1e-12)
    for _ in range(15):
        physics.step(np.zeros((COUNT, names.NUM_JOINTS)))
    state = physics.read()
    assert (lowest_clearance(state) > -0.002).all(), "feet sink in as little as in a plane"
    force = state.foot_forces.sum(axis=1).mean()
    np.testing.assert_allclose(force, physics.masses[0] * 9.81, rtol=0.1)


def test_a_robot_that_leaves_the_field_goes_on_in_its_world():
    physics = stand(disturbed_physics(COUNT, SETTING))
    placed = offsets(physics)[:, 0]
    physics.qvel[:, 0] = 3.0
    xs = [physics.read().base_position[:, 0]]
    heights, feet = [], []
    for _ in range(15):
        physics.step(np.zeros((COUNT, names.NUM_JOINTS)))
        state = physics.read()
        xs.append(state.base_position[:, 0])
        heights.append(lowest_clearance(state))
        feet.append(state.foot_positions[:, :, 0])
    now = offsets(physics)[:, 0]
    assert np.isin((now - placed).round(9), [0.0, 4.0]).all(), "by whole periods"
    assert (now - placed > 1.0).any(), "somebody was put back by a period"
    assert (np.abs(np.diff(feet, axis=0)) < 0.2).all(), "no jumps"
    moved = np.diff(xs, axis=0)
    assert (np.abs(moved) < 0.1).all(), "no jumps"
    assert ((physics.qpos[:, :2] >= 0) & (physics.qpos[:, :2] < 4.0)).all()
    assert np.min(heights) > -0.02


def test_the_scan_reads_the_ground_below_each_point():
    state = replace(
        make_arrays(2, base_position=[[50.0, 20.0, 6.0], [50.0, 20.0, 6.0]], yaw=[0.0, np.pi / 2]),
        ground=ramp(2),
    ).tensors(FLOAT64)
    scan = height_scan(make_view(state)).reshape(2, 15, 12)
    x = 0.1 * (np.arange(15) - 7.0)
    y = 0.1 * (np.arange(12) - 5.5)
    np.testing.assert_allclose(scan[0], np.tile(6.0 - 5.0 - 0.1 * x[:, None], 12), atol=1e-9)
    np.testing.assert_allclose(scan[1], np.tile(1.0 + 0.1 * y, (15, 1)), atol=1e-9)
    flat = height_scan(make_view(replace(state, ground=FLAT)))
    np.testing.assert_array_equal(flat, 6.0)


def test_base_height_and_terminations_are_about_the_ground_below():
    heights = [5.0 + 0.5, 5.0 + 0.3]
    state = replace(
        make_arrays(2, base_position=[[50.0, 0.0, heights[0]], [50.0, 0.0, heights[1]]]),
        ground=ramp(2),
    ).tensors(FLOAT64)
    np.testing.assert_allclose(state.base_height, [0.5, 0.3])
    np.testing.assert_array_equal(terminations.failed(state, {"base_height": 0.4}), [False, True])
    view = make_view(state)
    np.testing.assert_allclose(base_height(view)[:, 0], state.base_height - view.nominal_height)
