"""A delayed input is the same input, a whole number of simulation steps later."""

import numpy as np
import pytest

from slider.config.types import Interval
from slider.env.disturbance import DelayLine
from slider.robot import names
from slider.robot.mjcf import Actuation
from tests.env.synthetic import disturbed_physics, stand

TIMESTEP = 0.005
EVERY = np.arange(1)


@pytest.mark.parametrize("substeps", [1, 4])
@pytest.mark.parametrize("late", [0, 1, 3, 4, 6])
def test_shifts_by_simulation_steps_whatever_the_rate_of_the_controller(late, substeps):
    line = DelayLine(Interval(late * TIMESTEP, late * TIMESTEP), TIMESTEP, 1, 1)
    line.draw(EVERY, np.array([0.3]))
    line.fill(EVERY, np.array([[-1.0]]))
    issued = np.repeat(np.arange(24 // substeps), substeps).astype(float)
    calls = issued.reshape(-1, 1, substeps, 1)
    arrived = np.concatenate([line.pass_on(call)[0, :, 0] for call in calls])
    np.testing.assert_array_equal(arrived, np.concatenate([[-1.0] * late, issued])[:24])


def test_each_robot_has_its_own_delay_and_all_of_them_occur():
    line = DelayLine(Interval(0.0, 0.03), TIMESTEP, 7, 1)
    line.draw(np.arange(7), np.arange(7) / 7 + 0.01)
    np.testing.assert_array_equal(line.steps, np.arange(7))
    line.fill(np.arange(7), np.zeros((7, 1)))
    arrived = np.concatenate(
        [line.pass_on(np.full((7, 4, 1), float(k)))[:, :, 0] for k in (1, 2, 3)], axis=1
    )
    np.testing.assert_array_equal((arrived == 0).sum(axis=1), line.steps)


@pytest.mark.parametrize("actuation", ["position", "torque"])
def test_physics_with_delay_is_physics_with_shifted_inputs(actuation: Actuation):
    late, steps = 3, 40
    rng = np.random.default_rng(0)
    size = 0.02 if actuation == "position" else 3.0
    inputs = size * rng.standard_normal((steps, 2, names.NUM_JOINTS))
    delayed = disturbed_physics(
        2, "delay={lower: 0.015, upper: 0.015}", actuation=actuation, substeps=1
    )
    prompt = disturbed_physics(2, actuation=actuation, substeps=1)
    shifted = np.concatenate([np.zeros((late, 2, names.NUM_JOINTS)), inputs])
    stand(delayed), stand(prompt)
    for k in range(steps):
        delayed.step(inputs[k])
        prompt.step(shifted[k])
        np.testing.assert_array_equal(delayed.qpos, prompt.qpos)
        np.testing.assert_array_equal(delayed.read().motor_torques, prompt.read().motor_torques)
    assert np.abs(delayed.qvel).max() > 0.1, "nothing moved: the comparison would prove little"


def test_the_pose_is_held_or_no_torque_given_before_the_first_input_arrives():
    setting, inputs = "delay={lower: 0.02, upper: 0.02}", np.full((1, names.NUM_JOINTS), 0.05)
    torque = stand(disturbed_physics(1, setting, actuation="torque"))
    bent = torque.qpos.copy()
    bent[:, 7:] += 0.05
    torque.reset(np.arange(1), bent, np.zeros((1, 18)))
    torque.step(inputs)
    np.testing.assert_allclose(torque.read().motor_torques, 0.0, atol=1e-9)
    torque.step(inputs)
    assert np.abs(torque.read().motor_torques).max() > 0.01
    position, held = stand(disturbed_physics(1, setting)), stand(disturbed_physics(1))
    position.step(inputs), held.step(np.zeros_like(inputs))
    np.testing.assert_array_equal(position.qpos, held.qpos)
