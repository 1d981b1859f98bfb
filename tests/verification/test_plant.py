"""MuJoCo's inverse dynamics and impacts."""

import numpy as np
import pinocchio as pin
import pytest

from slider.robot import names
from slider.verification.plant import plant_state
from tests.verification.sample import pinocchio, plant


def random_states(count: int):
    """Standing pinocchio robots with random motions of the knee's joints."""
    rng, robot = np.random.default_rng(0), pinocchio()
    for side in names.SIDES:
        for _ in range(count):
            q, v, a = rng.normal(size=(3, 10)) * [[0.2], [2.0], [20.0]]
            q[[3, 8]] = rng.uniform(0.3, 1.5, 2)
            roll = rng.normal(size=3) * [0.1, 1.0, 5.0]
            yield side, robot.standing(roll, *robot.joint_motion(q, v, a), side)


def test_pinocchio_and_mujoco_agree_on_random_motions_and_impacts():
    """Two dynamics of the prismatic robot, each with its own way to masses, rotors, friction."""
    driven = list(names.GAIT_JOINTS)
    for side, state in random_states(10):
        efforts, wrench = pinocchio().inverse_dynamics(state, side)
        forces, jacobian = plant().inverse(plant_state(state), side)
        rest = forces - jacobian.T @ wrench
        np.testing.assert_allclose(rest[:6], 0.0, atol=1e-8)
        np.testing.assert_allclose(rest[6:][driven], efforts, atol=1e-8)
        landing = names.SIDES[1 - names.SIDES.index(side)]
        after = pinocchio().impact(state.q, state.v, landing)
        other = plant().impact(plant_state(state), landing)
        np.testing.assert_allclose(other[6:], after[6:], atol=1e-9)
        held = pinocchio().jacobian(state.q, landing) @ after
        np.testing.assert_allclose(held[[0, 1, 2, 4, 5]], 0.0, atol=1e-9)
        lost, kept = (moment_about_the_line(state.q, v, landing) for v in (state.v, after))
        assert kept == pytest.approx(lost, abs=1e-9)
        assert abs(lost) > 0.1


def moment_about_the_line(q: np.ndarray, v: np.ndarray, side: str) -> float:
    """Angular momentum about the sole along x: the line of a standing foot [N m s]."""
    robot = pinocchio()
    momentum = pin.computeCentroidalMomentum(robot.model, robot.data, q, v)
    sole = robot.foot_ends(q, side).mean(axis=0)
    arm = robot.data.com[0] - sole
    return float((momentum.angular + np.cross(arm, momentum.linear))[0])
