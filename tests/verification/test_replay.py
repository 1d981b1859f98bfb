"""The replay in MuJoCo: drives, and that foot placement is what keeps the robot up."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from slider.robot import names
from slider.robot.mjcf import SimulationOptions, build_model
from slider.robot.transmission import Transmission
from slider.verification.inverse_kinematics import level_leg
from slider.verification.replay import Simulation, regulated, tabulate
from tests.robot.lopsided import lopsided, turned
from tests.verification.sample import config, gaits, plant, turning_gaits


def simulation(steps: int) -> Simulation:
    settings = replace(config().verification.replay, steps=steps)
    return Simulation(config().robot, settings)


@pytest.mark.parametrize("turns", [False, True])
def test_foot_placement_keeps_a_gait_up_along_its_course(turns):
    """With the course of another gait the same regulator places the feet wrongly."""
    gait, robot = (turning_gaits() if turns else gaits())[1], simulation(12)
    walk = regulated(gait, robot, plant())
    assert walk["regulated_steps"] == 12
    assert walk["regulated_speed"] < 0.03
    assert robot.course == pytest.approx(6 * gait.turns.sum())
    heading = robot.data.xmat[robot.base].reshape(3, 3)[:, 0]
    assert np.arctan2(heading[1], heading[0]) == pytest.approx(robot.course, abs=0.2)
    assert (robot.course > 1.0) == turns


def test_a_gait_that_cannot_start_has_no_speed():
    robot = simulation(3)
    gait = gaits()[1]
    upside_down = gait.base.copy()
    upside_down[0, 3:7] = [0.0, 1.0, 0.0, 0.0]
    walk = regulated(replace(gait, base=upside_down), robot, plant())
    assert walk == {"regulated_steps": 0.0}


def motor_torques(robot: Simulation, targets: np.ndarray, reference) -> np.ndarray:
    """Torques (10,) that the motors make at the state in which they are commanded."""
    q, v = robot.data.qpos.copy(), robot.data.qvel.copy()
    robot.drive(targets, reference)
    robot.data.qpos[:], robot.data.qvel[:] = q, v
    mujoco.mj_forward(robot.model, robot.data)
    return robot.data.actuator_force.copy()


@pytest.mark.parametrize("sample", [0, 7, 20, 21, 35])
def test_on_the_gait_the_motors_make_the_gaits_own_efforts(sample):
    robot, gait = simulation(1), gaits()[1]
    step, time = gait.step_of(sample), gait.time_in_step(sample)
    state = plant().moving(gait.steps[step], time)
    reference = tabulate(gait, plant(), gait.half)[step].at(time)
    robot.data.qpos[:], robot.data.qvel[:] = state.qpos, state.qvel
    made = motor_torques(robot, reference.joints, reference)
    expected = Transmission.of(config().robot).torques(gait.efforts[sample])
    np.testing.assert_allclose(made, expected, atol=1e-6)
    assert np.abs(expected).max() > 1.0


def test_drives_add_the_gains_times_the_error():
    robot, gait = simulation(1), gaits()[1]
    reference = tabulate(gait, plant(), 11)[0].at(0.0)
    robot.start(gait, reference)
    targets = reference.joints.copy()
    targets[[2, 3]] += [0.01, 0.001]
    robot_kp, drum = config().robot.gains, config().robot.capstan.drum_radius
    before = motor_torques(robot, reference.joints, reference)
    added = motor_torques(robot, targets, reference) - before
    capstan = 0.001 / drum * robot_kp["capstan"].kp
    expected = [0, 0, 0.01 * robot_kp["hip_pitch"].kp, capstan, capstan, *[0] * 5]
    np.testing.assert_allclose(added, expected, atol=1e-9)


@pytest.mark.parametrize("robot", [config().robot, lopsided(), turned(False), turned(True)])
@pytest.mark.parametrize("side", names.SIDES)
def test_the_sole_is_where_it_should_be_and_its_line_along_the_heading(side, robot):
    model = build_model(robot, SimulationOptions())
    data = mujoco.MjData(model)
    rng = np.random.default_rng(3)
    sign = 1.0 if side == "left" else -1.0
    for _ in range(20):
        rotation = Rotation.from_euler("xyz", rng.normal(size=3) * 0.15)
        position = np.array([0.0, 0.0, 0.7]) + rng.normal(size=3) * 0.03
        sole = np.array([0.0, sign * 0.1, 0.0]) + rng.normal(size=3) * 0.05
        heading = Rotation.from_euler("zy", rng.normal(size=2) * 0.1).as_matrix()[:, 0]
        base = position, rotation.as_matrix()
        joints = level_leg(robot.geometry, side, base, sole, heading, np.zeros(5))
        data.qpos[:7] = [*position, *rotation.as_quat(scalar_first=True)]
        start = 7 + names.SIDES.index(side) * names.LEG_SIZE
        data.qpos[start : start + 5] = joints
        mujoco.mj_kinematics(model, data)
        foot = data.site(names.sole(side))
        np.testing.assert_allclose(foot.xpos, sole, atol=1e-12)
        np.testing.assert_allclose(foot.xmat.reshape(3, 3)[:, 0], heading, atol=1e-12)
