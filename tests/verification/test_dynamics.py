"""The roll against closed forms."""

import numpy as np
import pinocchio as pin
import pytest
from scipy.interpolate import BPoly

from slider.config.gait import IntegratorConfig
from slider.verification.dynamics import integrate_roll
from slider.verification.stored import StepMotion
from tests.verification.sample import pinocchio

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
