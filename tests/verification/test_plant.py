"""MuJoCo's inverse dynamics and impacts."""

import numpy as np
import pinocchio as pin
import pytest
from scipy.interpolate import BPoly

from slider.config.gait import IntegratorConfig
from slider.robot.names import SIDES, driven_joints, other_side
from slider.verification.dynamics import integrate_roll
from slider.verification.pin_robot import PinRobot
from slider.verification.plant import Plant, plant_state
from slider.verification.stored import StepMotion
from tests.robot.lopsided import soled
from tests.verification.sample import config, pinocchio


@pytest.mark.parametrize("soles", [False, True])
def test_pinocchio_and_mujoco_agree_on_random_motions_and_impacts(soles):
    """Two dynamics of the prismatic robot, each with its own way to masses, rotors, friction."""
    own = soled() if soles else config().robot
    rng, robot, plant = np.random.default_rng(0), PinRobot(own, "prismatic"), Plant(own)
    for side in SIDES * 10:
        q, v, a = rng.normal(size=(3, 10)) * [[0.2], [2.0], [20.0]]
        q[[3, 8]] = rng.uniform(0.3, 1.5, 2)
        roll = rng.normal(size=3) * [0.1, 1.0, 5.0]
        state = robot.standing(roll, *robot.joint_motion(q, v, a), side)
        efforts, wrench = robot.inverse_dynamics(state, side)
        forces, jacobian = plant.inverse(plant_state(state), side)
        rest = forces - jacobian.T @ wrench
        np.testing.assert_allclose(rest[:6], 0.0, atol=1e-8)
        np.testing.assert_allclose(rest[6:][[*driven_joints(own.geometry)]], efforts, atol=1e-8)
        landing = other_side(side)
        after = robot.impact(state.q, state.v, landing)
        other = plant.impact(plant_state(state), landing)
        np.testing.assert_allclose(other[6:], after[6:], atol=1e-8)
        held = robot.jacobian(state.q, landing) @ after
        if soles:
            np.testing.assert_allclose(held, 0.0, atol=1e-9)
            continue
        np.testing.assert_allclose(held[[0, 1, 2, 4, 5]], 0.0, atol=1e-9)
        lost, kept = (moment_about_the_line(robot, state.q, v, landing) for v in (state.v, after))
        assert kept == pytest.approx(lost, abs=1e-9)
        assert abs(lost) > 0.1


def moment_about_the_line(robot: PinRobot, q: np.ndarray, v: np.ndarray, side: str) -> float:
    """Angular momentum about the sole along x: the line of a standing foot [N m s]."""
    momentum = pin.computeCentroidalMomentum(robot.model, robot.data, q, v)
    sole = robot.foot_ends(q, side).mean(axis=0)
    arm = robot.data.com[0] - sole
    return float((momentum.angular + np.cross(arm, momentum.linear))[0])


FINE = IntegratorConfig(1e-10, 1e-12)
POSE = np.array([0.1, -0.1, -0.4, 0.9, -0.45, 0.05, 0.2, -0.5, 1.1, -0.6])


@pytest.mark.parametrize("side", ["left", "right"])
def test_locked_joints_make_a_pendulum_that_keeps_its_energy(side):
    still = BPoly(POSE[None, None, :], [0.0, 0.4])
    curves = (still, still.derivative(), still.derivative(2))
    motion, times = StepMotion(side, 0.4, curves, curves), np.linspace(0.0, 0.4, 9)
    path = integrate_roll(pinocchio(), motion, FINE, np.array([0.05, -0.4]), times)

    def energy(roll, rate):
        robot = pinocchio()
        state = robot.moving(motion, 0.0, np.array([roll, rate, 0.0]))
        pin.computeMechanicalEnergy(robot.model, robot.data, state.q, state.v)
        return robot.data.mechanical_energy

    energies = [energy(*state) for state in path]
    assert np.ptp(path[:, 0]) > 0.02
    np.testing.assert_allclose(energies, energies[0], atol=1e-8)
