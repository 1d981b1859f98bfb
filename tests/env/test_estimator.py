"""The state estimated on board against the true one: swaying, sliding, thrown, reset, noisy."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from slider.config.env import OnboardConfig, SensorsConfig
from slider.env.estimator import Leg, StateEstimator
from slider.env.interface import FLOAT64
from slider.env.observations import height_scan
from slider.env.physics import BatchedPhysics
from slider.env.state import RobotState
from slider.robot.bodies import own_bodies, total_mass
from slider.robot.mjcf import SimulationOptions, build_model, nominal_qpos
from slider.robot.names import GRAVITY, NUM_JOINTS
from slider.robot.transmission import Transmission
from tests.env.synthetic import (
    JOINTS,
    config,
    disturbed_physics,
    make_arrays,
    make_view,
    robot_config,
    stand,
)
from tests.robot.lopsided import kneed, turned

ONBOARD = config("experiment=test").env.onboard
NO_ERRORS = SensorsConfig(*[0.0] * 17)
PERFECT = replace(ONBOARD, sensors=NO_ERRORS)
COUNT = 3
LEGS = {"slider": robot_config(), "kneed": kneed(), "turned": turned(True)}
ROBOTS = pytest.mark.parametrize("robot", LEGS.values(), ids=LEGS)


def physics_with(onboard: OnboardConfig, terrain: str = "flat", level: float = 5.0):
    text = f"terrain={{kinds: [{terrain}], level: {{lower: {level}, upper: {level}}}}}"
    return disturbed_physics(COUNT, text, onboard=onboard)


def sway(step: int) -> np.ndarray:
    """Targets (N, 12) at which the base moves to and fro above feet that rest."""
    targets = np.zeros((COUNT, NUM_JOINTS))
    for name, size in (("hip_pitch", 0.02), ("ankle", -0.02), ("slide", 0.03)):
        columns = [JOINTS.index(f"{side}_{name}") for side in ("left", "right")]
        targets[:, columns] = size * np.sin(0.2 * step + np.arange(COUNT))[:, None]
    return targets


def swayed(physics: BatchedPhysics, steps: int = 80) -> list[tuple[RobotState, RobotState]]:
    """Estimates and true states of robots that sway, after half a second, before they fall over."""
    pairs = []
    for step in range(steps):
        physics.step(sway(step))
        true = physics.read()
        pairs.append((physics.measure(true), true))
    return pairs[25:]


def errors(pairs: list[tuple[RobotState, RobotState]], name: str) -> np.ndarray:
    return np.array([getattr(estimate, name) - getattr(true, name) for estimate, true in pairs])


def test_feet_that_stick_give_velocity_and_height_without_sensor_errors():
    pairs = swayed(stand(physics_with(PERFECT), 0.2))
    assert max(np.abs(true.qvel[:, :3]).max() for _, true in pairs) > 0.1, "the robots move"
    assert np.abs(errors(pairs, "base_height")).max() < 0.003
    for name, columns in (("qvel", 3), ("base_position", 2), ("foot_positions", 3)):
        assert np.abs(errors(pairs, name)[..., :columns]).max() < 0.01, name
    assert errors(pairs, "foot_forces").std() < 10.0, "of 61 N on each foot"


def test_errors_of_sensors_are_those_of_an_instant_and_repeat_after_a_restart():
    physics = physics_with(ONBOARD)
    first = errors(swayed(stand(physics, 0.2)), "qvel")[..., :3]
    rms = np.sqrt((first**2).mean((0, 1)))
    assert ((rms > 0.005) & (rms < 0.06)).all()
    once, twice = (physics.measure(physics.read()) for _ in range(2))
    for name in ("linear_velocity", "base_position", "foot_forces", "joint_positions"):
        np.testing.assert_array_equal(getattr(once, name), getattr(twice, name))
    physics.restart_disturbances()
    again = errors(swayed(stand(physics, 0.2)), "qvel")[..., :3]
    np.testing.assert_array_equal(again, first)


def test_a_reset_leaves_the_other_robots_alone():
    physics, other = (stand(physics_with(PERFECT), 0.2) for _ in range(2))
    swayed(physics, 40), swayed(other, 40)
    physics.reset(np.array([0]), physics.qpos[:1].copy(), 0.7 * np.eye(1, 18))
    reset, kept = physics.measure(physics.read()), other.measure(other.read())
    np.testing.assert_array_equal(reset.linear_velocity[1:], kept.linear_velocity[1:])
    # The feet hang on a base that moves: they say what they measure, 0.7 m/s less than the truth.
    assert abs(reset.heading_velocity[0, 0]) < 0.01


HEIGHT = 0.64 + 0.045  # of the hips
STILL = np.array([[0.0, 0.0, 0.02 * GRAVITY]])  # increment of a robot that stands upright


def estimator() -> StateEstimator:
    """Of one robot that stood still when it started."""
    made = StateEstimator(ONBOARD.estimator, robot_config(), 1, np.zeros(1))
    made.update(make_arrays(1), STILL, np.zeros(1))
    return made


def test_without_a_loaded_foot_the_inertial_unit_alone_counts():
    """Motors without torque: a free fall, in which the unit feels nothing."""
    filter_ = estimator()
    for step in range(1, 6):
        found = filter_.update(make_arrays(1), np.zeros((1, 3)), np.full(1, 0.02))
        assert found.velocity[0] == pytest.approx([0.0, 0.0, -GRAVITY * 0.02 * step])
    fallen = GRAVITY * 0.02**2 * (1 + 2 + 3 + 4 + 5)
    assert found.position[0, 2] == pytest.approx(HEIGHT - fallen)


def carrying() -> np.ndarray:
    """Motor torques (1, 10) [N m] with which both legs carry a robot that stands."""
    sliding = 0.97 + 2 * 0.0737  # the slides carry the rest [kg]
    force = (12.525 / 2 - sliding) * GRAVITY * robot_config().capstan.drum_radius / 2
    torques = np.zeros((1, 10))
    torques[:, [3, 4, 8, 9]] = force
    return torques


def test_a_bias_of_the_inertial_unit_leaves_no_error_of_velocity():
    bias = np.array([[0.2, -0.1, 0.05]])
    filter_, reading = estimator(), make_arrays(1, motor_torques=carrying())
    for _ in range(500):
        found = filter_.update(reading, STILL + 0.02 * bias, np.full(1, 0.02))
    np.testing.assert_allclose(filter_.bias, bias, atol=1e-3)
    assert np.abs(found.velocity).max() < 1e-3


def test_a_slipping_foot_is_outweighed_by_the_other():
    """The left leg says 2 m/s, the right one that the robot rests; both carry the robot."""
    rates, filter_ = np.eye(12)[[JOINTS.index("left_hip_pitch")]] * 2.0 / HEIGHT, estimator()
    reading = make_arrays(1, motor_torques=carrying(), joint_velocities=rates)
    for _ in range(10):
        found = filter_.update(reading, STILL, np.full(1, 0.02))
    assert found.foot_forces[0, 1] == pytest.approx(12.525 * GRAVITY / 2, rel=1e-3)
    assert abs(found.velocity[0, 0]) < 0.1


@ROBOTS
def test_a_foot_s_force_is_that_against_which_the_motors_hold_the_leg(robot):
    """By MuJoCo's Jacobian; legs have no weight in it."""
    model, jacobian = build_model(robot, SimulationOptions()), np.zeros((3, 6 + NUM_JOINTS))
    data, force = mujoco.MjData(model), total_mass(own_bodies(robot)) * GRAVITY
    data.qpos[:] = nominal_qpos(robot)
    mujoco.mj_forward(model, data)
    mujoco.mj_jacSite(model, data, jacobian, None, model.site("left_sole").id)
    efforts = -force * jacobian[None, 2, 6:]
    reading = make_arrays(1, motor_torques=Transmission.of(robot).torques(efforts))
    made = StateEstimator(ONBOARD.estimator, robot, 1, np.zeros(1))
    made.update(reading, STILL, np.zeros(1))
    found = made.update(reading, STILL, np.full(1, 0.02)).foot_forces[0]
    np.testing.assert_allclose(found, [force + Leg.of(robot).mass * GRAVITY, 0.0], rtol=1e-9)


def scans(sensors: SensorsConfig, kind: str = "slope_up", steps: int = 0) -> tuple[np.ndarray, ...]:
    """Height scans (N, 180) by the estimate and by the true state, of robots that slide forward."""
    physics = stand(physics_with(replace(ONBOARD, sensors=sensors), kind))
    physics.qvel[:, 0] = 1.0
    for _ in range(steps):
        physics.step(np.zeros((COUNT, NUM_JOINTS)))
        physics.measure(physics.read())
        physics.qvel[:, 0] = 1.0
    true = physics.read()
    states = physics.measure(true).tensors(FLOAT64), true.tensors(FLOAT64)
    return tuple(height_scan(make_view(state)).numpy() for state in states)


@pytest.mark.parametrize(("kind", "steps"), [("flat", 0), ("slope_up", 0), ("tiles", 25)])
def test_a_scan_moves_and_turns_with_the_robot_whatever_its_estimate(kind, steps):
    """Place and heading of the estimate are off: the scan is still that around the robot."""
    sensors = replace(NO_ERRORS, heading_drift=1.0, acceleration_bias=1.0)
    measured, expected = scans(sensors, kind, steps)
    np.testing.assert_allclose(measured, expected, atol=1e-9)
    assert (np.ptp(expected, axis=1) > 0.02).all() == (kind != "flat")


def test_a_scan_has_noise_bias_drop_outs_and_a_delay():
    noise, bias, lost, late = (
        np.subtract(*scans(replace(NO_ERRORS, **{f"scan{name}": size})))
        for name, size in (("", 0.02), ("_bias", 0.02), ("_drop_out", 0.2), ("_delay", 0.1))
    )
    np.testing.assert_allclose(noise.std(), 0.02, rtol=0.1)
    assert np.ptp(bias, axis=1).max() < 1e-9
    assert 0.01 < bias.std() < 0.04
    assert 0.15 < (np.abs(lost) > 1e-6).mean() < 0.25
    np.testing.assert_allclose(late, 0.1 * np.tan(np.radians(6.25)), atol=1e-9)
