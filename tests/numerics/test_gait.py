"""Solved gaits, straight and turning, against closed forms, symmetry and MuJoCo."""

from functools import cache

import mujoco
import numpy as np
import pytest

from slider.gait.constraints import Constraint
from slider.gait.solve import Nlp
from slider.gait.stage import gait_arrays
from slider.robot.kinematics import rotation_from_quaternion, yaw_of
from slider.robot.mjcf import SimulationOptions, build_model
from slider.robot.names import JOINTS, leg_joint
from slider.robot.transmission import Transmission
from tests.gait.gaits import config, problem, solved
from tests.numerics.test_derivatives import flat, near_a_gait

Velocity = tuple[float, float, float]
STRAIGHT: Velocity = (0.6, 0.05, 0.0)
TURNING: Velocity = (0.5, 0.1, -0.3)
IMAGE: Velocity = (0.5, -0.1, 0.3)
both = pytest.mark.parametrize("velocity", [STRAIGHT, TURNING], ids=["straight", "turning"])


@cache
def arrays(velocity: Velocity) -> dict[str, np.ndarray]:
    assert solved(*velocity).success
    return gait_arrays(problem(velocity[2] != 0.0), solved(*velocity), "exact", velocity[2])


def sliced(constraints: list[Constraint]) -> dict[str, list[slice]]:
    """Rows of each name, once per touchdown."""
    rows, start = {}, 0
    for constraint in constraints:
        rows.setdefault(constraint.name, []).append(slice(start, start + constraint.size))
        start += constraint.size
    return rows


@both
def test_all_constraints_hold(velocity):
    gait, samples = solved(*velocity), arrays(velocity)["samples"]
    assert gait.max_violation <= 1e-6
    assert gait.residuals.keys() >= {"impact", "friction", "touchdown_velocity"}
    position, rates = samples[:, :12], samples[:, 12:24]
    motors = Transmission.of(config().robot)
    for share in motors.shares(arrays(velocity)["efforts"], rates):
        assert np.abs(share).max() <= 1 + 1e-6
    for i, name in enumerate(JOINTS):
        joint = config().robot.joints[leg_joint(name)]
        assert joint.lower - 1e-6 <= position[:, i].min()
        assert position[:, i].max() <= joint.upper + 1e-6
    assert not position[:, [5, 11]].any(), "upper feet"


@both
def test_reflected_velocities_have_reflected_gaits(velocity):
    """Legs swapped: the steps of (vx, −vy, −ω) are those of (vx, vy, ω) in the other order."""
    vx, vy, yaw_rate = velocity
    gait, image = solved(*velocity), solved(vx, -vy, -yaw_rate)
    assert image.success
    assert image.cost == pytest.approx(gait.cost, rel=1e-6)
    steps = gait.variables.reshape(2, -1)
    np.testing.assert_allclose(image.variables.reshape(2, -1), steps[::-1], atol=2e-5)
    assert np.abs(steps[0] - steps[1]).max() > 1e-2


@both
@pytest.mark.parametrize("k", [0, 7, 20, 21, 30, 41])
def test_the_prismatic_robot_stands_where_the_gait_says(velocity, k):
    """MuJoCo's kinematics: stance sole on its line, yawed in the second step; swing sole."""
    found = arrays(velocity)
    model = build_model(config().robot, SimulationOptions())
    data = mujoco.MjData(model)
    data.qpos[:] = np.concatenate([found["base"][k, :7], found["samples"][k, :12]])
    data.qvel[:] = np.concatenate([found["base"][k, 7:], found["samples"][k, 12:24]])
    mujoco.mj_forward(model, data)
    second = k >= 21
    stance, swing = ("right", "left") if second else ("left", "right")
    yaw = velocity[2] * found["step_time"][0] * second
    axes = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
    origin = np.append(found["swing_foot"][20, :2], 0.0) * second
    np.testing.assert_allclose(data.sensor(f"{stance}_sole_position").data, origin, atol=1e-7)
    other = data.sensor(f"{swing}_sole_position").data
    np.testing.assert_allclose(other, origin + axes @ found["swing_foot"][k], atol=1e-7)
    np.testing.assert_allclose(data.sensor(f"{stance}_sole_velocity").data, 0.0, atol=1e-7)
    line = data.site(f"{stance}_sole").xmat.reshape(3, 3)[:, 0]
    np.testing.assert_allclose(line, axes[:, 0], atol=1e-7)


def test_without_a_yaw_rate_the_rows_of_a_turning_walk_are_those_of_a_straight_one():
    """To the last bit; the mean velocity is the base's then, and the feet's here."""
    x, velocity = solved(0.5, 0.1).variables, [0.5, 0.1, 0.0]
    for away in (0.0, 0.05):
        y = x + away * np.random.default_rng(0).normal(size=x.size)
        straight, turning = (
            flat(Nlp(problem(turning)).objective_and_rows(y, velocity)[1])
            for turning in (False, True)
        )
        mean = next(b.rows for b in problem().blocks if b.name == "mean_velocity")
        others = np.delete(np.arange(len(straight)), mean)
        np.testing.assert_array_equal(turning[others], straight[others])
        if not away:
            np.testing.assert_allclose(turning[mean], straight[mean], atol=1e-6)


def test_rows_are_those_of_the_reflected_command_with_the_steps_swapped():
    ends = problem(turning=True).functions["ends"]
    y = flat(problem().layout.select_ends @ near_a_gait())
    swapped = np.roll(y, len(y) // 2)
    own, image = flat(ends(y, TURNING)), flat(ends(swapped, IMAGE))
    for name, places in sliced(problem(turning=True).end_constraints).items():
        sign = {"mean_velocity": [1, -1], "equal_step_lengths": -1, "equal_step_times": -1}
        other = places[::-1]
        for place, partner in zip(places, other, strict=True):
            expected = np.array(sign.get(name, 1)) * image[partner]
            np.testing.assert_allclose(own[place], expected, atol=1e-12, err_msg=name)


def test_the_heading_changes_by_the_yaw_rate_times_the_walk():
    found = arrays(TURNING)
    yaw = yaw_of(rotation_from_quaternion(found["base"][:, 3:7]))
    walk = found["step_time"].sum()
    assert yaw[-1] - yaw[0] == pytest.approx(TURNING[2] * walk, abs=1e-8)
    course = TURNING[2] * (found["time"] - found["step_time"][0] / 2)
    assert np.abs(np.sin(yaw - course)).max() <= 1.005 * config().gait.posture.torso_yaw


def test_the_base_moves_on_without_a_jump_and_along_the_commanded_arc():
    found, (vx, vy, yaw_rate) = arrays(TURNING), TURNING
    base, time = found["base"], found["step_time"]
    np.testing.assert_allclose(base[20, :7], base[21, :7], atol=1e-6)
    second = yaw_rate * time[0]
    back = np.array([[np.cos(second), np.sin(second)], [-np.sin(second), np.cos(second)]])
    ways = base[20, :2] - base[0, :2], back @ (base[41, :2] - base[21, :2])
    np.testing.assert_allclose(sum(ways) / time.sum(), (vx, vy), atol=1e-7)
    speed = found["samples"][:, -2:].reshape(2, 21, 2)
    mean = np.trapezoid(speed, dx=1 / 20, axis=1).mean(axis=0)
    np.testing.assert_allclose(mean, (vx, vy), atol=0.01)  # the heading swings
