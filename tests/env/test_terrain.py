"""Terrain: closed forms, the boxes in MuJoCo, feet on them, starts, scan, guide and curriculum."""

from dataclasses import replace
from functools import cache
from typing import get_args

import mujoco
import numpy as np
import pytest

from slider.config.env import TerrainKind
from slider.env import terminations
from slider.env.height_field import FLAT, UnevenGround, adapt_to_terrain
from slider.env.interface import FLOAT64
from slider.env.observations import base_height, height_scan
from slider.env.physics import BatchedPhysics
from slider.env.state import RobotState
from slider.robot import names
from slider.robot.kinematics import foot_ends
from tests.env.synthetic import (
    JOINTS,
    disturbed_physics,
    make_arrays,
    make_guide,
    make_view,
    robot_config,
    stand,
)

COUNT = 12
KINDS = tuple(kind for kind in get_args(TerrainKind) if kind != "flat")


def on(*kinds: str, level: float = 5.0, more: tuple[str, ...] = (), **ends: float):
    """Physics of robots on kinds of terrain in turn; ``ends`` of the curriculum's levels."""
    lower, upper = ends.get("lower", level), ends.get("upper", level)
    text = f"kinds: [{', '.join(kinds)}], level: {{lower: {lower}, upper: {upper}}}"
    return disturbed_physics(COUNT, f"terrain={{{text}, curriculum: {bool(ends)}}}", *more)


def ground_of(physics: BatchedPhysics) -> UnevenGround:
    return physics.terrain.ground


def height(physics: BatchedPhysics, x: list[float], y: float = 0.0) -> np.ndarray:
    """Heights (N, points) [m] at places x on the way."""
    points = np.stack([x, np.full(len(x), y)], axis=1)
    return ground_of(physics).height(np.tile(points, (COUNT, 1, 1)))


def test_a_slope_across_rises_to_either_side():
    across = height(stand(on("slope_across")), [0.0], y=1.0)[:, 0]
    np.testing.assert_allclose(np.abs(across), np.tan(np.radians(5 * 1.25)))
    assert len(np.unique(across.round(9))) == 2


@pytest.mark.parametrize(("sign", "way"), [(1.0, "up"), (-1.0, "down")])
def test_slopes_steps_and_stairs_go_their_way(sign, way):
    """Steps and stairs begin after level ground."""
    slope = height(stand(on(f"slope_{way}")), [2.0])
    np.testing.assert_allclose(slope[0], sign * 2.0 * np.tan(np.radians(5 * 1.25)))
    step = height(stand(on(f"step_{way}")), [0.0, 0.29, 0.61, 5.0])
    np.testing.assert_allclose(step[0], sign * np.array([0.0, 0.0, 0.06, 0.06]))
    physics = stand(on(f"stairs_{way}"))
    starts = ground_of(physics).start
    assert np.ptp(starts) > 0.05, "not all at one place"
    edges = starts[0] + 0.3 * np.arange(12)
    risers = height(physics, [*(edges - 1e-6), *(edges + 1e-6), 20.0])[0]
    steps = [*range(12), *range(1, 13), 12]
    np.testing.assert_allclose(risers, sign * 0.05 * np.array(steps), atol=1e-12)


def test_gaps_lie_between_boards():
    physics = stand(on("gaps"))
    start = float(ground_of(physics).start[0])
    places = [start + 0.01, start + 0.07, start + 0.08, start + 0.39, start + 0.41]
    np.testing.assert_allclose(height(physics, places)[0], [-0.5, -0.5, 0.0, 0.0, -0.5])
    points = np.zeros((COUNT, 1, 2)) + [start + 0.01, 0.0]
    np.testing.assert_array_equal(ground_of(physics).height(points, gaps=False), 0.0)


def test_tiles_are_level_within_themselves_and_about_the_start():
    physics = stand(on("tiles"))
    middle = height(physics, [1.0])
    np.testing.assert_array_equal(height(physics, [0.9, 1.1]), np.tile(middle, 2))
    far = height(physics, list(np.arange(2.0, 12.0, 0.25)))
    assert 0.035 < np.abs(far).max() <= 0.04
    assert np.ptp(far, axis=0).min() > 0.01, "every robot has other tiles"
    np.testing.assert_array_equal(height(physics, [-0.37, 0.0, 0.37], y=0.3), 0.0)


def test_the_gradient_of_a_field_is_that_of_its_heights():
    ground = ground_of(stand(on("rough")))
    points = np.random.default_rng(0).uniform(-3.0, 3.0, (COUNT, 200, 2))
    steps = 1e-6 * np.eye(2)
    numeric = [(ground.height(points + s) - ground.height(points - s)) / 2e-6 for s in steps]
    np.testing.assert_allclose(np.stack(numeric, axis=-1), ground.gradient(points), atol=1e-7)
    heights = ground.height(points)
    assert 0.015 < np.abs(heights).max() <= 0.02
    assert not ground.height(points[:, :1] * 0).any(), "level where the robot starts"


@pytest.mark.parametrize("kind", KINDS)
def test_a_ray_meets_the_ground_of_the_formula_under_every_foot(kind):
    physics = stand(on(kind))
    rng = np.random.default_rng(0)
    base = rng.uniform([0.0, -2.0], [6.0, 2.0], (COUNT, 2))
    feet = base[:, None] + [[0.2, 0.1], [-0.2, -0.1]]
    feet[::2] = base[::2, None] + [[0.02, 0.1], [-0.02, -0.1]]  # on the same tiles
    physics.terrain.follow(base, feet, np.zeros_like(feet))
    along = np.linspace(-0.085, 0.085, 7)
    points = feet[:, :, None] + np.stack([along, 0.001 + 0.0 * along], axis=-1)
    expected = ground_of(physics).height(points)
    tolerance = 0.002 if kind == "rough" else 1e-9  # which is its tangent plane at the foot
    for robot, model in enumerate(physics.models):
        measured = [[_ray(model, point) for point in foot] for foot in points[robot]]
        np.testing.assert_allclose(measured, expected[robot], atol=tolerance)


def _ray(model: mujoco.MjModel, point: np.ndarray) -> float:
    data = mujoco.MjData(model)
    data.qpos[2] = 50.0
    mujoco.mj_forward(model, data)
    model.geom_group[:] = np.where(model.geom_bodyid == 0, 0, 1)
    above, down = np.array([*point, 3.0]), np.array([0.0, 0.0, -1.0])
    group, geom = np.array([1, 0, 0, 0, 0, 0], dtype=np.uint8), np.zeros(1, dtype=np.int32)
    return 3.0 - mujoco.mj_ray(model, data, above, down, group, 1, -1, geom, None)


def clearance(physics: BatchedPhysics) -> np.ndarray:
    """Of points along both feet above the ground (N, 2, 5) [m]."""
    state, line = physics.read(), np.linspace(0.0, 1.0, 5)[:, None]
    ends = foot_ends(robot_config().geometry, state.rotation, state.joint_positions)
    ends = ends + state.base_position[:, None, None]
    points = (1 - line) * ends[:, :, :1] + line * ends[:, :, 1:]
    return points[..., 2] - state.ground.height(points[..., :2])


def test_level_tiles_push_a_dropped_robot_upwards():
    """Spheres that sink in at a seam would be pushed sideways."""
    physics, wrench = stand(on("tiles", level=0.02)), np.zeros(6)
    rng, force = np.random.default_rng(0), np.zeros(2)  # horizontal and vertical [N]
    for robot, model in enumerate(physics.models):
        data = mujoco.MjData(model)
        data.qpos[:] = physics.qpos[robot]
        data.qpos[:3] += [*rng.uniform(-0.1, 0.1, 2), 0.03]
        data.qvel[:3] = rng.uniform([0.0, 0.0, -0.5], [1.0, 0.0, 0.0])
        mujoco.mj_forward(model, data)
        data.ctrl[:] = data.actuator_length
        for _ in range(60):
            mujoco.mj_step(model, data)
            for index, contact in enumerate(data.contact):
                if 0 in model.geom_bodyid[contact.geom]:
                    mujoco.mj_contactForce(model, data, index, wrench)
                    normal = np.abs(contact.frame[:3])
                    force += wrench[0] * np.array([np.hypot(*normal[:2]), normal[2]])
    assert force[1] > 1e4
    assert force[0] < 0.02 * force[1]


@pytest.mark.parametrize("kind", ["slope_up", "slope_down", "slope_across", "tiles", "rough"])
def test_a_start_fits_the_ground_which_carries_the_robot(kind):
    physics = stand(on(kind))
    np.testing.assert_allclose(clearance(physics).min(axis=(1, 2)), 0.0, atol=1e-9)
    assert clearance(physics).min(axis=2).max() < 0.004, "both feet are on the ground"
    held = physics.qpos[:, 7:].copy()
    for _ in range(10):
        physics.step(held)
    assert clearance(physics).min() > -0.002, "feet sink in as little as in a plane"
    force = physics.read().foot_forces.sum(axis=1)
    np.testing.assert_allclose(force, physics.masses * 9.81, rtol=0.2)


def test_boxes_follow_feet_that_walk_on():
    physics = stand(on("stairs_up", "tiles", "rough"))
    for step in range(30):  # carried over the ground, feet down
        physics.qvel[:, 0] = 2.0
        physics.step(np.zeros((COUNT, names.NUM_JOINTS)))
        if step == 5:
            physics.qpos[:, 2] += 0.3
            physics.qvel[:, 2] = 0.0
    feet = physics.read().foot_positions[..., :2]
    here = ground_of(physics).height(feet)
    for robot in range(0, COUNT, 3):
        found = [_ray(physics.models[robot], foot) for foot in feet[robot]]
        np.testing.assert_allclose(found, here[robot], rtol=0, atol=0.003)


@cache
def ramp() -> UnevenGround:
    """Rises with x."""
    ground = ground_of(stand(on("slope_up"))).of(np.arange(2))
    return replace(ground, slope=np.array([[0.1, 0.0]] * 2))


def on_ramp(**quantities: np.ndarray | list) -> RobotState:
    return replace(make_arrays(2, **quantities), ground=ramp()).tensors(FLOAT64)


def test_the_scan_reads_the_ground_below_each_point():
    state = on_ramp(base_position=[50.0, 20.0, 6.0], yaw=[0.0, np.pi / 2])
    scan = height_scan(make_view(state)).reshape(2, 15, 12)
    x, y = 0.1 * (np.arange(15) - 7.0), 0.1 * (np.arange(12) - 5.5)
    np.testing.assert_allclose(scan[0], np.tile(6.0 - 5.0 - 0.1 * x[:, None], 12), atol=1e-9)
    np.testing.assert_allclose(scan[1], np.tile(1.0 + 0.1 * y, (15, 1)), atol=1e-9)
    flat = height_scan(make_view(replace(state, ground=FLAT)))
    np.testing.assert_array_equal(flat, 6.0)


def test_base_height_and_terminations_are_about_the_ground_under_the_feet():
    feet = [[49.0, 0.1, 0.0], [51.0, -0.1, 0.0]]
    state = on_ramp(base_position=[[50.0, 0.0, 5.5], [50.0, 0.0, 5.3]], foot_positions=feet)
    np.testing.assert_allclose(state.base_height, [0.5, 0.3])
    np.testing.assert_array_equal(terminations.failed(state, {"base_height": 0.4}), [False, True])
    view = make_view(state)
    np.testing.assert_allclose(base_height(view)[:, 0], state.base_height - view.nominal_height)


def test_the_guide_follows_the_ground_under_each_foot():
    feet = np.array([[[0.2, 0.1], [-0.2, -0.1]]] * 2)
    geometry, joints = robot_config().geometry, np.zeros((2, names.NUM_JOINTS))
    change = adapt_to_terrain(ramp(), feet, np.array([0.0, np.pi]), geometry, joints)
    columns = [JOINTS.index(name) for name in ("left_slide", "right_slide", "left_ankle")]
    turn = np.arctan(0.1)
    expected = [[-0.02, 0.02, -turn], [-0.02, 0.02, turn]]
    np.testing.assert_allclose(change[:, columns], expected, atol=1e-12)
    positions = np.concatenate([feet, np.zeros((2, 2, 1))], axis=-1)
    uneven = make_view(on_ramp(foot_positions=positions, yaw=[0.0, np.pi]))
    level = replace(uneven, state=replace(uneven.state, ground=FLAT))
    difference = make_guide().at_phase(uneven) - make_guide().at_phase(level)
    np.testing.assert_allclose(difference[:, :12], change, atol=1e-12)
    assert not difference[:, 12:].any()


def test_levels_go_up_with_a_walk_and_down_with_a_fall():
    physics = stand(on("stairs_up", "flat", lower=2.0, upper=4.0))
    levels = physics.terrain
    assert levels.mean_level == 2.0
    walked, fell = np.arange(COUNT) < 6, np.arange(COUNT) >= 8
    levels.grade(walked, fell)
    np.testing.assert_array_equal(levels.levels[[0, 6, 8]], [3.0, 2.0, 2.0])
    stand(physics)
    np.testing.assert_allclose(ground_of(physics).rise[[0, 6]], [0.03, 0.02])
    for _ in range(2):
        levels.grade(np.ones(COUNT, dtype=bool), ~np.ones(COUNT, dtype=bool))
    assert levels.levels[0] == 5.0
    stand(physics)  # beyond the highest level: any of them
    drawn = levels.levels[[0, 2, 4]]
    assert ((drawn >= 2.0) & (drawn <= 4.0)).all()
    assert np.ptp(drawn) > 0.1
