"""Solved gaits against other integrators, closed forms and the prismatic robot."""

import casadi as ca
import mujoco
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from slider.gait import bezier
from slider.gait.solution import base_motion
from slider.gait.stage import gait_arrays
from slider.gait.tree import NUM_JOINTS
from slider.robot import knee_map
from slider.robot.mjcf import SimulationOptions, build_model
from slider.robot.names import CHANNELS, JOINTS

VELOCITY = (0.6, 0.05)


@pytest.fixture(scope="module")
def arrays(formulation, solved):
    return gait_arrays(solved.problem, solved.solve, formulation, "exact")


def test_all_constraints_hold(solved):
    assert solved.solve.max_violation <= 1e-6
    assert solved.solve.residuals.keys() >= {"impact", "friction", "touchdown_velocity"}


def test_mean_velocity_is_the_command(arrays):
    """Simpson's rule over the base velocity, and the displacement of one walk."""
    half = len(arrays["time"]) // 2
    weights = np.ones(half)
    weights[1:-1:2], weights[2:-1:2] = 4.0, 2.0
    walk = arrays["step_time"].sum()
    for axis, command in enumerate(VELOCITY):
        velocity = arrays["base"][:, 7 + axis].reshape(2, half)
        intervals = arrays["step_time"] / (half - 1)
        travelled = (velocity @ weights * intervals / 3).sum()
        assert travelled / walk == pytest.approx(command, abs=2e-4)
    first, last = arrays["base"][0, :2], arrays["base"][-1, :2]
    np.testing.assert_allclose((last - first) / walk, VELOCITY, atol=1e-6)


def test_walk_is_periodic(solved, arrays):
    """After the second touchdown the first sample comes again."""
    nodes = solved.problem.nodes
    before = arrays["knee_positions"][2 * nodes - 1]
    np.testing.assert_allclose(before, arrays["knee_positions"][0], atol=1e-6)
    np.testing.assert_allclose(arrays["base"][-1, 2:7], arrays["base"][0, 2:7], atol=1e-6)


def test_roll_agrees_with_another_integrator(solved, formulation):
    """DOP853 along the Bézier outputs, roll acceleration from the zero-moment condition."""
    layout, tree = solved.problem.layout, formulation.tree
    roll, rate, acceleration = (ca.SX.sym(name) for name in "rda")
    q, v, a = (ca.SX.sym(name, NUM_JOINTS) for name in "qva")
    dynamics = tree.inverse_dynamics(roll, rate, acceleration, q, v, a)
    moment = tree.line_wrench(roll, dynamics)[1][0]
    slope = ca.jacobian(moment, acceleration)
    solve = ca.Function(
        "roll", [roll, rate, q, v, a], [-ca.substitute(moment, acceleration, 0) / slope]
    )
    variables = solved.solve.variables
    time = variables[layout.time_index(0)]
    coefficients = variables[layout.joint_slice(0)].reshape(NUM_JOINTS, -1)

    def outputs(t, order):
        return bezier.evaluate(coefficients, np.array([t / time]), order)[0] / time**order

    def derivative(t, x):
        joints = (outputs(t, 0), outputs(t, 1), outputs(t, 2))
        return [x[1], float(solve(x[0], x[1], *joints))]

    nodes = variables[layout.time_index(0) + 1 : layout.step_size].reshape(-1, 3)
    result = solve_ivp(derivative, (0, time), nodes[0, :2], "DOP853", rtol=1e-10, atol=1e-12)
    # The roll is unstable: collocation errors grow about fivefold over a step.
    np.testing.assert_allclose(result.y[0, -1], nodes[-1, 0], atol=1e-3)
    np.testing.assert_allclose(result.y[1, -1], nodes[-1, 1], atol=5e-3)
    assert np.ptp(nodes[:, 0]) > 0.01


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


def test_limits_of_the_drives_hold_at_the_nodes(arrays, config):
    velocity = arrays["samples"][:, len(JOINTS) : 2 * len(JOINTS)]
    for i, name in enumerate(JOINTS):
        limit = config.robot.limits[name.split("_", 1)[1]]
        assert np.abs(velocity[:, i]).max() <= limit.speed + 1e-6
        assert np.abs(arrays["efforts"][:, i]).max() <= limit.effort + 1e-4
        assert arrays["samples"][:, i].min() >= limit.lower - 1e-6
        assert arrays["samples"][:, i].max() <= limit.upper + 1e-6


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
