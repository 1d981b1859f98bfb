"""Solved gaits against closed forms and the prismatic robot; more in ``tests/verification``."""

import mujoco
import numpy as np
import pytest

from slider.gait import bezier
from slider.gait.solution import base_motion
from slider.gait.stage import gait_arrays
from slider.gait.tree import NUM_JOINTS
from slider.robot import knee_map
from slider.robot.mjcf import SimulationOptions, build_model
from slider.robot.names import CHANNELS, JOINTS, leg_joint
from slider.robot.transmission import Transmission

VELOCITY = (0.6, 0.05)


@pytest.fixture(scope="module")
def arrays(solved):
    return gait_arrays(solved.problem, solved.solve, "exact")


def test_all_constraints_hold(solved):
    assert solved.solve.max_violation <= 1e-6
    assert solved.solve.residuals.keys() >= {"impact", "friction", "touchdown_velocity"}


def test_opposite_lateral_velocities_mirror_each_other(solver, solved):
    """The steps of (vx, −vy) are those of (vx, vy) in the other order."""
    other = solver.solve(VELOCITY[0], -VELOCITY[1])
    assert other.success
    steps = solved.solve.variables.reshape(2, -1)
    np.testing.assert_allclose(other.variables.reshape(2, -1), steps[::-1], atol=2e-5)
    assert np.abs(steps[0] - steps[1]).max() > 1e-2


def test_prismatic_velocities_are_derivatives_of_positions(solved, config):
    """Eq. 1 along the stance leg: central differences of the exact positions; not the paper's."""
    knee = config.robot.virtual_knee
    lengths = (knee.thigh_length, knee.shank_length)
    layout, variables = solved.problem.layout, solved.solve.variables
    time = variables[layout.time_index(0)]
    coefficients = variables[layout.joint_slice(0)].reshape(NUM_JOINTS, -1)[2:5]
    s, shift = np.linspace(0.05, 0.95, 19), 1e-6
    place = [bezier.evaluate(coefficients, s + d).T for d in (shift, -shift)]
    theta = bezier.evaluate(coefficients, s)[:, 1]
    pitch_rate, rate, ankle_rate = bezier.evaluate(coefficients, s, 1).T / time
    errors = {}
    for variant in knee_map.VARIANTS:
        up, down = (knee_map.positions(*p, *lengths, variant) for p in place)
        found = knee_map.velocities(pitch_rate, theta, rate, ankle_rate, *lengths, variant)
        errors[variant] = max(
            np.abs(
                (getattr(up, n) - getattr(down, n)) / (2 * shift * time) - getattr(found, n)
            ).max()
            for n in ("hip_pitch", "length", "ankle")
        )
    assert errors["exact"] < 1e-6
    assert errors["paper"] > 0.05


def test_motors_can_make_it_and_joints_are_within_their_range_at_the_nodes(arrays, config):
    position, velocity = arrays["samples"][:, :12], arrays["samples"][:, 12:24]
    torque, voltage = Transmission.of(config.robot).shares(arrays["efforts"], velocity)
    assert np.abs(torque).max() <= 1 + 1e-6
    assert np.abs(voltage).max() <= 1 + 1e-6
    for i, name in enumerate(JOINTS):
        joint = config.robot.joints[leg_joint(name)]
        assert joint.lower - 1e-6 <= position[:, i].min()
        assert position[:, i].max() <= joint.upper + 1e-6


def test_channels(arrays):
    assert arrays["samples"].shape == (42, 26)
    passive = [i for i, name in enumerate(CHANNELS) if "upper_foot" in name]
    assert np.all(arrays["samples"][:, passive] == 0.0)


@pytest.mark.parametrize("k", [0, 7, 20, 21, 30, 41])
def test_prismatic_robot_stands_where_the_gait_says(config, arrays, k):
    """MuJoCo's kinematics of the converted sample: both soles and the stance sole's velocity."""
    model = build_model(config.robot, SimulationOptions())
    data = mujoco.MjData(model)
    data.qpos[:] = np.concatenate([arrays["base"][k, :7], arrays["samples"][k, :12]])
    data.qvel[:] = np.concatenate([arrays["base"][k, 7:], arrays["samples"][k, 12:24]])
    mujoco.mj_forward(model, data)
    second = k >= 21
    stance, swing = ("right", "left") if second else ("left", "right")
    origin = np.append(arrays["swing_foot"][20, :2], 0.0) if second else np.zeros(3)
    sole = data.sensor(f"{stance}_sole_position").data
    np.testing.assert_allclose(sole, origin, atol=1e-8)
    other = data.sensor(f"{swing}_sole_position").data
    np.testing.assert_allclose(other, origin + arrays["swing_foot"][k], atol=1e-8)
    np.testing.assert_allclose(data.sensor(f"{stance}_sole_velocity").data, 0.0, atol=1e-8)


def test_base_motion_is_continuous_at_touchdown(solved):
    trajectory = solved.trajectory
    motion = base_motion(trajectory, trajectory.swing_foot[20, :2])
    np.testing.assert_allclose(motion[20, :7], motion[21, :7], atol=1e-6)
    assert np.abs(motion[20, 7:] - motion[21, 7:]).max() > 1e-2
