"""The decoupling matrix by M⁻¹ and the transmission."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from slider.gait.outputs import ANKLE, LEG, YAW, output_matrix
from slider.gait.rooted import NUM, RootedRobot, decoupling
from slider.robot.transmission import Transmission
from tests.env.synthetic import GEOMETRY
from tests.gait.gaits import config
from tests.robot.lopsided import kneed, lopsided, turned


@pytest.mark.parametrize("robot", [lopsided(), kneed(), turned(False), turned(True)])
def test_absolute_outputs_are_the_turns_of_torso_swing_leg_and_swing_foot(robot):
    """By differences of rotation matrices, all joints at zero."""
    robot = replace(robot, virtual_knee=None)
    rooted, hip = RootedRobot(robot), {"hip_yaw": "yaw", "hip_roll": "roll", "hip_pitch": "pitch"}
    bodies = "base", f"swing_{hip[robot.geometry.axes.order[-1]]}", "swing_foot"
    poses = rooted.poses(rooted.q)
    turn = ca.Function("turn", [rooted.q], [poses[name].rotation for name in bodies])
    ahead, behind = (
        [np.array([np.asarray(r.full()) for r in turn(sign * 1e-6 * unit)]) for unit in np.eye(NUM)]
        for sign in (1, -1)
    )
    rates = (np.array(ahead) - np.array(behind)) / 2e-6  # (11, body, 3, 3), skew
    turns = np.stack([rates[..., 1, 0], rates[..., 2, 1], rates[..., 0, 2]], axis=-1)
    rows = np.delete(output_matrix(robot.geometry), YAW, axis=1)
    for body, found in enumerate((rows[:3], rows[LEG : LEG + 3])):
        np.testing.assert_allclose(found, turns[:, body].T, atol=1e-9)
    np.testing.assert_allclose(rows[LEG + ANKLE], turns[:, 2, 2], atol=1e-9)


def test_singular_values_of_the_accelerations_that_full_torques_give():
    """By the transmission and M⁻¹."""
    rng = np.random.default_rng(1)
    robot, q = config().robot, 0.2 * rng.standard_normal((2, NUM))
    rooted, motors = RootedRobot(robot), Transmission.of(robot)
    rows = np.delete(output_matrix(GEOMETRY), YAW, axis=1)
    efforts = np.delete(motors.efforts(np.diag(motors.torque)), [5, 11], axis=1).T
    for place, (least, condition) in zip(q, decoupling(robot, q), strict=True):
        mass = rooted.dynamics(place, np.zeros(NUM))[0].full()
        accelerations = rows @ np.linalg.solve(mass, np.r_[np.zeros((1, 10)), efforts])
        values = np.linalg.svd(accelerations, compute_uv=False)
        np.testing.assert_allclose([least, condition], [values[-1], values[0] / values[-1]], 1e-4)
        assert least > 1.0
