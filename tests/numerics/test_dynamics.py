"""The rooted Newton-Euler dynamics against pinocchio's floating-base robot."""

from dataclasses import replace

import numpy as np
import pytest

from slider.gait.formulation import Formulation
from slider.verification.pin_robot import PinRobot
from tests.gait.gaits import config, inverse_dynamics


@pytest.mark.parametrize("dynamics", ["prismatic", "knee"])
@pytest.mark.parametrize("thigh", [0.36, 0.39])
def test_random_motions(dynamics, thigh):
    """Also of a thigh that is longer than the shank, so that no term vanishes."""
    robot, rng = config().robot, np.random.default_rng(0)
    robot = replace(robot, virtual_knee=replace(robot.virtual_knee, thigh_length=thigh))
    pinocchio = PinRobot(robot, dynamics)
    rooted = inverse_dynamics(Formulation(robot, replace(config().gait, dynamics=dynamics)))
    for _ in range(20):
        x = rng.normal(size=33) * [0.2, 1, 5, *[0.5] * 10, *[1] * 10, *[2] * 10]
        x[[6, 11]] = rng.uniform(0.3, 1.5, 2)  # knees: the slide's force needs them bent
        joints = pinocchio.joint_motion(x[3:13], x[13:23], x[23:33])
        forces, wrench = pinocchio.inverse_dynamics(pinocchio.standing(x[:3], *joints))
        expected = [*pinocchio.work(x[3:13], forces), wrench[:3], wrench[3:]]
        for value, right in zip(rooted(np.append(x, 1.0)), expected, strict=True):
            np.testing.assert_allclose(np.array(value).ravel(), right, atol=1e-8)
