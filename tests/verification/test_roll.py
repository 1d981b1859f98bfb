"""The roll dynamics: closed forms, and the stored gait as one orbit of the return map."""

import numpy as np
import pytest
from scipy.interpolate import BPoly

from slider.config.verification import IntegratorConfig
from slider.verification.roll import RollDynamics, return_map
from slider.verification.stored import StepMotion
from tests.verification.sample import config, gaits, pinocchio

FINE = IntegratorConfig(1e-10, 1e-12)
POSE = np.array([0.1, -0.1, -0.4, 0.9, -0.45, 0.05, 0.2, -0.5, 1.1, -0.6])


def frozen(side: str) -> RollDynamics:
    """The robot with its joints locked: a pendulum about the foot line."""
    still = BPoly(POSE[None, None, :], [0.0, 0.4])
    curves = (still, still.derivative(), still.derivative(2))
    return RollDynamics(pinocchio(), StepMotion(side, 0.4, curves, curves), FINE)


@pytest.mark.parametrize("side", ["left", "right"])
def test_locked_joints_make_a_pendulum_that_keeps_its_energy(side):
    dynamics = frozen(side)
    path = dynamics.integrate(np.array([0.05, -0.4]), np.linspace(0.0, 0.4, 9))

    def energy(roll, rate):
        robot = pinocchio()
        state = robot.moving(dynamics.motion, 0.0, np.array([roll, 0.0, 0.0]))
        _, inertia = robot.line_moment_and_inertia(state, side)
        return inertia * rate**2 / 2 + robot.mass_total * 9.81 * robot.centre(state.q)[2]

    energies = [energy(*state) for state in path]
    assert np.ptp(path[:, 0]) > 0.02
    np.testing.assert_allclose(energies, energies[0], atol=1e-8)


def test_moment_about_the_line_is_linear_in_the_roll_acceleration():
    robot = pinocchio()
    for side in ("left", "right"):
        states = [
            robot.standing(np.array([0.1, 0.3, a]), POSE, POSE, POSE, side) for a in (0.0, 1.0)
        ]
        moment, inertia = robot.line_moment_and_inertia(states[0], side)
        wrenches = [robot.inverse_dynamics(state, side)[1][3] for state in states]
        assert moment == pytest.approx(wrenches[0], abs=1e-9)
        assert inertia == pytest.approx(wrenches[1] - wrenches[0], abs=1e-9)


def test_momentum_carries_the_stored_gait_over_both_impacts():
    gait = gaits()[1]
    both = [RollDynamics(pinocchio(), motion, FINE) for motion in gait.steps]
    for current, following in zip(both, both[::-1], strict=True):
        end = current.motion.roll_at(current.motion.duration)[:2]
        roll, momentum = current.momentum_after(end)
        start = following.motion.roll_at(0.0)[:2]
        found = [roll, following.rate_of(roll, momentum)]
        np.testing.assert_allclose(found, start, atol=1e-6)


def test_return_map_does_not_depend_on_the_size_of_its_differences():
    coarse = return_map(gaits()[1], pinocchio(), FINE, 1e-3)
    fine = return_map(gaits()[1], pinocchio(), FINE, 1e-5)
    np.testing.assert_allclose(coarse, fine, rtol=2e-3, atol=1e-3)
    assert np.abs(np.linalg.eigvals(fine)).max() > 5.0  # the open loop falls sideways


def test_return_map_is_that_of_the_mirrored_gait():
    settings = config().verification
    maps = [
        return_map(gait, pinocchio(), settings.integrator, settings.perturbation)
        for gait in gaits()[:2]
    ]
    moduli = [np.sort(np.abs(np.linalg.eigvals(m))) for m in maps]
    np.testing.assert_allclose(moduli[0], moduli[1], rtol=1e-3)
