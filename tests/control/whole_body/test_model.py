"""The nominal model's terms against finite differences and MuJoCo's other routines."""

import mujoco
import numpy as np
import pytest

from tests.control.walking import nominal
from tests.env.synthetic import random_pose

EPS = 1e-6


def moved(qpos: np.ndarray, qvel: np.ndarray, time: float) -> np.ndarray:
    """Positions after ``time`` at constant generalised velocity: q̈ = 0."""
    result = qpos.copy()
    for row, rate in zip(result, qvel, strict=True):
        mujoco.mj_integratePos(nominal().model, row, rate, time)
    return result


@pytest.mark.parametrize("count", [1, 32, 45])
def test_terms_of_many_robots_are_mujocos_of_each(count):
    """Also where the robots are not a multiple of the model's copies."""
    qpos, qvel = random_pose(np.random.default_rng(5), count)
    found = nominal().evaluate(qpos, qvel)
    model, data = nominal().model, mujoco.MjData(nominal().model)
    feet = [(model.body(f"{s}_foot").id, model.site(f"{s}_sole").id) for s in ("left", "right")]
    mass, jacobian, rate = np.zeros((18, 18)), np.zeros((6, 18)), np.zeros((6, 18))
    for i in range(count):
        data.qpos[:], data.qvel[:] = qpos[i], qvel[i]
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        mujoco.mj_fullM(model, data, mass)
        np.testing.assert_allclose(found.mass_matrix[i], mass, rtol=1e-12, atol=1e-14)
        bias = data.qfrc_bias - data.qfrc_passive  # of the joints' damping
        np.testing.assert_allclose(found.bias[i], bias, rtol=1e-12, atol=1e-11)
        np.testing.assert_allclose(found.com[i], data.subtree_com[1], rtol=1e-12, atol=1e-14)
        np.testing.assert_array_equal(found.base_rotation[i].ravel(), data.xmat[1])
        for leg, (body, sole) in enumerate(feet):
            place = data.site_xpos[sole]
            np.testing.assert_array_equal(found.foot_positions[i, leg], place)
            np.testing.assert_array_equal(
                found.foot_rotations[i, leg].ravel(), data.site_xmat[sole]
            )
            mujoco.mj_jac(model, data, jacobian[:3], jacobian[3:], place, body)
            mujoco.mj_jacDot(model, data, rate[:3], rate[3:], place, body)
            np.testing.assert_allclose(found.foot_jacobians[i, leg], jacobian, rtol=0, atol=1e-14)
            np.testing.assert_allclose(found.foot_bias[i, leg], rate @ qvel[i], rtol=0, atol=1e-11)


def test_com_and_its_bias_are_those_of_differences_without_joint_acceleration():
    poses = random_pose(np.random.default_rng(3), 4)
    dynamics = nominal().evaluate(*poses)
    data, jacobian = mujoco.MjData(nominal().model), np.zeros((3, 18))
    for i in range(4):
        data.qpos[:], data.qvel[:] = poses[0][i], poses[1][i]
        mujoco.mj_forward(nominal().model, data)
        mujoco.mj_jacSubtreeCom(nominal().model, data, jacobian, 1)
        np.testing.assert_allclose(dynamics.com_jacobian[i], jacobian, atol=1e-10)
    ahead, behind = (nominal().evaluate(moved(*poses, s * EPS), poses[1]) for s in (1, -1))
    np.testing.assert_allclose(
        dynamics.com_velocity, (ahead.com - behind.com) / (2 * EPS), atol=1e-7
    )
    com = (ahead.com_velocity - behind.com_velocity) / (2 * EPS)
    np.testing.assert_allclose(dynamics.com_bias, com, atol=1e-5)
