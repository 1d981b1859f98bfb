"""The replay in MuJoCo: drives, and that foot placement is what keeps the robot up."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from slider.robot import names
from slider.verification.prismatic import PrismaticRobot
from slider.verification.reference import tabulate
from slider.verification.replay import Simulation, replays
from tests.verification.sample import config, gaits, pinocchio


def simulation(steps: int) -> Simulation:
    settings = replace(config().verification.replay, steps=steps)
    return Simulation(config().robot, settings)


def slides() -> PrismaticRobot:
    return PrismaticRobot(config().robot)


def test_foot_placement_keeps_up_what_targets_alone_do_not():
    found = replays(gaits()[1], simulation(12), pinocchio(), slides())
    assert found["regulated_steps"] == 12
    assert found["replay_steps"] < 12
    assert found["regulated_speed"] < 0.15


def test_the_same_replay_twice_is_the_same():
    robot = simulation(2)
    first, second = (replays(gaits()[1], robot, pinocchio(), slides()) for _ in range(2))
    assert first == second


def test_a_gait_that_cannot_start_has_no_speed():
    robot = simulation(3)
    gait = gaits()[1]
    upside_down = gait.base.copy()
    upside_down[0, 3:7] = [0.0, 1.0, 0.0, 0.0]
    found = replays(replace(gait, base=upside_down), robot, pinocchio(), slides())
    assert found == {"replay_steps": 0.0, "regulated_steps": 0.0}


@pytest.mark.parametrize("step", [0, 1])
def test_table_starts_where_the_gait_does(step):
    gait = gaits()[1]
    reference = tabulate(gait, pinocchio(), slides(), 11)[step]
    sample = step * gait.half
    start = reference.at(0.0)
    np.testing.assert_allclose(start.joints, gait.samples[sample, : names.NUM_JOINTS], atol=1e-10)
    np.testing.assert_allclose(start.swing, gait.swing_foot[sample], atol=1e-6)
    np.testing.assert_allclose(start.direction, [1, 0, 0], atol=1e-6)
    end = reference.at(10.0)
    last = reference.table[-1, : names.NUM_JOINTS]
    np.testing.assert_allclose(end.joints, last, rtol=1e-12)


def test_drives_give_the_gains_times_the_error_and_the_feed_forward():
    robot = simulation(1)
    reference = tabulate(gaits()[1], pinocchio(), slides(), 11)[0].at(0.0)
    robot.start(gaits()[1], reference)
    q, v = robot.data.qpos[7:].copy(), robot.data.qvel[6:].copy()
    wanted = reference.joints.copy()
    wanted[2] += 0.01
    robot.drive(wanted, reference)
    robot.data.qpos[7:], robot.data.qvel[6:] = q, v
    mujoco.mj_forward(robot.model, robot.data)
    expected = 0.01 * config().robot.gains["hip_pitch"].kp + reference.efforts[2]
    assert robot.data.actuator_force[2] == pytest.approx(expected, abs=1e-6)
