"""Solved gaits, straight and turning, against closed forms, symmetry and MuJoCo."""

from functools import cache

import mujoco
import numpy as np
import pytest

from slider.gait.stage import gait_arrays
from slider.robot.kinematics import rotation_from_quaternion, yaw_of
from slider.robot.mjcf import SimulationOptions, build_model
from tests.gait.gaits import config, problem, solved

Velocity = tuple[float, float, float]
STRAIGHT: Velocity = (0.6, 0.05, 0.0)
TURNING: Velocity = (0.5, 0.1, -0.3)
both = pytest.mark.parametrize("velocity", [STRAIGHT, TURNING], ids=["straight", "turning"])


@cache
def arrays(velocity: Velocity) -> dict[str, np.ndarray]:
    assert solved(*velocity).success
    return gait_arrays(problem(velocity[2] != 0.0), solved(*velocity), "exact", velocity[2])


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


def test_the_heading_swings_about_the_course_within_its_bound():
    found = arrays(TURNING)
    yaw = yaw_of(rotation_from_quaternion(found["base"][:, 3:7]))
    course = TURNING[2] * (found["time"] - found["step_time"][0] / 2)
    assert np.abs(np.sin(yaw - course)).max() <= 1.005 * config().gait.posture.torso_yaw
    speed = found["samples"][:, -2:].reshape(2, 21, 2)
    mean = np.trapezoid(speed, dx=1 / 20, axis=1).mean(axis=0)
    np.testing.assert_allclose(mean, TURNING[:2], atol=0.01)
