"""The nominal model's terms against finite differences and MuJoCo's other routines."""

import mujoco
import numpy as np
import pytest

from slider.control.mpc.nominal import NominalModel
from slider.robot import names
from tests.env.synthetic import random_pose, robot_config

EPS = 1e-6


@pytest.fixture(scope="module")
def nominal() -> NominalModel:
    return NominalModel(robot_config())


@pytest.fixture
def poses() -> tuple[np.ndarray, np.ndarray]:
    return random_pose(np.random.default_rng(3), 4)


def moved(nominal: NominalModel, qpos: np.ndarray, qvel: np.ndarray, time: float) -> np.ndarray:
    """Positions after ``time`` at constant generalised velocity: q̈ = 0."""
    result = qpos.copy()
    for row, rate in zip(result, qvel, strict=True):
        mujoco.mj_integratePos(nominal.model, row, rate, time)
    return result


def test_mass_matrix_rows_are_the_jacobian_of_the_centre_of_mass(nominal, poses):
    dynamics = nominal.evaluate(*poses)
    data, jacobian = mujoco.MjData(nominal.model), np.zeros((3, 18))
    for i in range(4):
        data.qpos[:], data.qvel[:] = poses[0][i], poses[1][i]
        mujoco.mj_forward(nominal.model, data)
        mujoco.mj_jacSubtreeCom(nominal.model, data, jacobian, 1)
        np.testing.assert_allclose(dynamics.com_jacobian[i], jacobian, atol=1e-10)
    ahead, behind = (nominal.evaluate(moved(nominal, *poses, s * EPS), poses[1]) for s in (1, -1))
    np.testing.assert_allclose(
        dynamics.com_velocity, (ahead.com - behind.com) / (2 * EPS), atol=1e-7
    )


def test_biases_are_the_accelerations_without_joint_acceleration(nominal, poses):
    dynamics = nominal.evaluate(*poses)
    ahead, behind = (nominal.evaluate(moved(nominal, *poses, s * EPS), poses[1]) for s in (1, -1))
    com = (ahead.com_velocity - behind.com_velocity) / (2 * EPS)
    np.testing.assert_allclose(dynamics.com_bias, com, atol=1e-5)
    speeds = [
        (case.foot_jacobians @ poses[1][:, None, :, None])[..., 0] for case in (ahead, behind)
    ]
    np.testing.assert_allclose(dynamics.foot_bias, (speeds[0] - speeds[1]) / (2 * EPS), atol=1e-5)


def test_foot_jacobians_are_the_derivatives_of_the_soles(nominal, poses):
    dynamics = nominal.evaluate(*poses)
    ahead, behind = (nominal.evaluate(moved(nominal, *poses, s * EPS), poses[1]) for s in (1, -1))
    speed = (dynamics.foot_jacobians[:, :, :3] @ poses[1][:, None, :, None])[..., 0]
    slope = (ahead.foot_positions - behind.foot_positions) / (2 * EPS)
    np.testing.assert_allclose(speed, slope, atol=1e-7)
    turn = (ahead.foot_rotations - behind.foot_rotations) / (2 * EPS)
    skew = turn @ dynamics.foot_rotations.swapaxes(-1, -2)
    angular = (dynamics.foot_jacobians[:, :, 3:] @ poses[1][:, None, :, None])[..., 0]
    np.testing.assert_allclose(angular[..., 2], skew[..., 1, 0], atol=1e-6)
    np.testing.assert_allclose(angular[..., 0], skew[..., 2, 1], atol=1e-6)


def test_equations_of_motion_are_mujocos(nominal, poses):
    """M q̈ + h = Sᵀτ with MuJoCo's own accelerations in the air."""
    dynamics = nominal.evaluate(*poses)
    data = mujoco.MjData(nominal.model)
    rng = np.random.default_rng(0)
    for i in range(4):
        data.qpos[:], data.qvel[:] = poses[0][i] + [0, 0, 5, *np.zeros(16)], poses[1][i]
        data.ctrl[:] = rng.uniform(-5, 5, 10)
        mujoco.mj_forward(nominal.model, data)
        force = dynamics.mass_matrix[i] @ data.qacc + dynamics.bias[i]
        expected = np.zeros(18)
        expected[6 + np.array(names.ACTUATED)] = data.actuator_force
        np.testing.assert_allclose(force, expected, atol=1e-6)


def test_height_of_the_pendulum(nominal):
    robot = robot_config()
    links = robot.links
    assert nominal.mass == pytest.approx(12.5248, abs=1e-9)
    assert 0.6 < nominal.nominal_height < 0.72
    leg = links.yaw.mass + links.roll.mass + links.pitch.mass + links.tube.mass
    leg += links.foot.mass + links.upper_foot.mass
    assert nominal.mass == pytest.approx(links.base.mass + 2 * leg)
