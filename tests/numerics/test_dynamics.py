"""The rooted Newton-Euler dynamics against pinocchio's floating-base robot."""

from dataclasses import replace

import numpy as np
import pytest

from slider.config.robot import RobotConfig
from slider.gait.formulation import Formulation
from slider.verification.pin_robot import PinRobot
from tests.gait.gaits import config, inverse_dynamics
from tests.robot.lopsided import kneed


def with_thigh(length: float) -> RobotConfig:
    robot = config().robot
    return replace(robot, virtual_knee=replace(robot.sliding_leg, thigh_length=length))


@pytest.mark.parametrize(
    ("robot", "dynamics"),
    [
        (with_thigh(0.36), "prismatic"),
        (with_thigh(0.36), "knee"),
        (with_thigh(0.39), "prismatic"),  # longer than the shank, so that no term vanishes
        (with_thigh(0.39), "knee"),
        (kneed(), "prismatic"),
    ],
)
def test_random_motions(robot, dynamics):
    rng = np.random.default_rng(0)
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
