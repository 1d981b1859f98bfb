"""The decoupling matrix by M⁻¹ and the transmission."""

import casadi as ca
import numpy as np
import pytest

from slider.gait.outputs import ANKLE, YAW, output_matrix
from slider.gait.rooted import NUM, RootedRobot, decoupling
from slider.robot.transmission import Transmission
from tests.gait.gaits import config


@pytest.mark.parametrize("by_hip", [False, True])
def test_singular_values_of_the_accelerations_that_full_torques_give(by_hip):
    """By the transmission and M⁻¹; the hip's row is the change of its place, by differences."""
    rng = np.random.default_rng(1)
    robot, q = config().robot, 0.2 * rng.standard_normal((2, NUM))
    rooted, motors = RootedRobot(robot), Transmission.of(robot)
    hip = ca.Function("hip", [rooted.q], [rooted.poses(rooted.q)["base"].origin[0]])
    rows = np.delete(output_matrix("absolute"), YAW, axis=1)
    efforts = np.delete(motors.efforts(np.diag(motors.torque)), [5, 11], axis=1).T
    for place, (least, condition) in zip(q, decoupling(robot, q, by_hip), strict=True):
        if by_hip:
            moved = place + 1e-6 * np.eye(NUM)
            rows[ANKLE] = [(float(hip(each)) - float(hip(place))) / 1e-6 for each in moved]
        mass = rooted.dynamics(place, np.zeros(NUM))[0].full()
        accelerations = rows @ np.linalg.solve(mass, np.r_[np.zeros((1, 10)), efforts])
        values = np.linalg.svd(accelerations, compute_uv=False)
        np.testing.assert_allclose([least, condition], [values[-1], values[0] / values[-1]], 1e-4)
        assert least > 1.0
