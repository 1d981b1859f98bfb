"""Motors and joints: by hand, by virtual work, and as MuJoCo simulates them."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from slider.config.robot import Drive
from slider.robot import names
from slider.robot.mjcf import Actuation, SimulationOptions, build_model
from slider.robot.names import NUM_GAIT_JOINTS, motor_names
from slider.robot.transmission import Transmission
from tests.config.composed import composed
from tests.env.synthetic import JOINTS, random_pose

SLIDER = composed().robot
CAPSTAN = Drive(torque=8.0, speed=120.0, stall_ratio=2.0, inertia=6.25e-4)  # for round numbers
ROBOT = replace(SLIDER, drives={**SLIDER.drives, "capstan": CAPSTAN})
MOTORS = Transmission.of(ROBOT)
RADIUS, RATIO = 0.025, 0.35  # of the capstan
TORQUE, STALL, NO_LOAD = 8.0, 16.0, 120.0  # of each of its motors
SLIDE, ANKLE = JOINTS.index("right_slide"), JOINTS.index("right_ankle")
ONE, TWO = (motor_names(ROBOT.geometry).index(f"right_leg_{k}") for k in (1, 2))
PASSIVE = [i for i in range(names.NUM_JOINTS) if i not in names.GAIT_JOINTS]


def joints(slide: float, ankle: float) -> np.ndarray:
    return slide * np.eye(names.NUM_JOINTS)[SLIDE] + ankle * np.eye(names.NUM_JOINTS)[ANKLE]


def motors(one: float, two: float) -> np.ndarray:
    return one * np.eye(NUM_GAIT_JOINTS)[ONE] + two * np.eye(NUM_GAIT_JOINTS)[TWO]


@pytest.mark.parametrize(
    ("slide", "ankle", "one", "two"),
    [
        (320.0, 0.0, 4.0, 4.0),  # each half of 320 N · 0.025 m
        (0.0, -16.0, -2.8, 2.8),  # each half of 16 N m · 0.35
        (320.0, -16.0, 1.2, 6.8),
        (-400.0, 10.0, -5.0 + 1.75, -5.0 - 1.75),
    ],
    ids=["slide", "ankle", "both", "both pull"],
)
def test_shares_of_the_motors_by_hand(slide, ankle, one, two):
    torques = MOTORS.torques(joints(slide, ankle))
    np.testing.assert_allclose(torques, motors(one, two), atol=1e-12)
    share, voltage = MOTORS.shares(joints(slide, ankle), joints(0.6, 2.1))
    np.testing.assert_allclose(share, motors(one / TORQUE, two / TORQUE), atol=1e-12)
    fast, slow = 0.6 / RADIUS + 2.1 / RATIO, 0.6 / RADIUS - 2.1 / RATIO  # 30 and 18 rad/s
    expected = motors(one / STALL + fast / NO_LOAD, two / STALL + slow / NO_LOAD)
    np.testing.assert_allclose(voltage, expected, atol=1e-12)


def test_motors_do_the_work_of_the_joints():
    rng = np.random.default_rng(0)
    efforts, speeds = rng.standard_normal((2, 30, names.NUM_JOINTS))
    efforts[:, PASSIVE] = 0.0
    work = (MOTORS.torques(efforts) * MOTORS.angles(speeds)).sum(axis=1)
    np.testing.assert_allclose(work, (efforts * speeds).sum(axis=1), atol=1e-12)
    np.testing.assert_allclose(MOTORS.efforts(MOTORS.torques(efforts)), efforts, atol=1e-12)


@pytest.mark.parametrize("actuation", ["position", "torque"])
def test_the_simulated_motors_have_these_limits_at_every_speed(actuation: Actuation):
    """What the plant makes of inputs that are far too large; both coupled motors at once."""
    model = build_model(ROBOT, SimulationOptions(actuation=actuation))
    rng = np.random.default_rng(1)
    for _ in range(20):
        rates = rng.uniform(-1.0, 1.0, names.NUM_JOINTS)
        rates *= np.array([18.0, 18.0, 18.0, 2.5, 15.0, 5.0] * 2)
        lower, upper = MOTORS.torque_limits(MOTORS.angles(rates))
        for sign, expected in ((1, upper), (-1, lower)):
            data = mujoco.MjData(model)
            data.qvel[6:], data.ctrl[:] = rates, sign * 1e5
            mujoco.mj_forward(model, data)
            np.testing.assert_allclose(data.actuator_force, expected, rtol=1e-9, atol=1e-9)


def test_position_loops_of_the_motors_are_those_of_the_joints():
    """kp (Δs/r ± Δβ/n) through the tendons is 2 kp/r² on the slide, 2 kp/n² on the ankle."""
    model = build_model(ROBOT, SimulationOptions())
    kp, kd = ROBOT.gains["capstan"].kp, ROBOT.gains["capstan"].kd
    hips = [ROBOT.gains[name] for name in ("hip_yaw", "hip_roll", "hip_pitch")]
    stiff = [*(g.kp for g in hips), 2 * kp / RADIUS**2, 2 * kp / RATIO**2, 0.0] * 2
    damped = [*(g.kd for g in hips), 2 * kd / RADIUS**2, 2 * kd / RATIO**2, 0.0] * 2
    assert stiff[3] == pytest.approx(6000.0)
    rng = np.random.default_rng(4)
    for qpos, qvel in zip(*random_pose(rng, 10), strict=True):
        target = qpos[7:] + rng.uniform(-1.0, 1.0, 12) * ([0.1, 0.1, 0.1, 0.01, 0.1, 0.0] * 2)
        data = mujoco.MjData(model)
        data.qpos[:], data.qvel[:] = qpos, 0.2 * qvel
        data.ctrl[:] = MOTORS.angles(target)
        mujoco.mj_forward(model, data)
        assert (np.abs(data.actuator_force) < 0.9 * MOTORS.torque).all(), "no limit is in the way"
        expected = np.array(stiff) * (target - qpos[7:]) - np.array(damped) * data.qvel[6:]
        np.testing.assert_allclose(data.qfrc_actuator[6:], expected, rtol=1e-9, atol=1e-9)
        assert not data.qfrc_actuator[:6].any()
