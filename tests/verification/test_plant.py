"""MuJoCo's inverse dynamics, impacts and distances."""

import mujoco
import numpy as np
import pytest

from slider.robot import names
from slider.robot.transmission import Transmission
from slider.verification.dynamics import stored_state, touchdowns
from slider.verification.plant import inverse_dynamics, plant_state
from tests.verification.sample import config, gaits, knee_gait, pinocchio, plant


def random_states(count: int):
    """Standing pinocchio robots with random motions of the knee's joints."""
    rng, robot = np.random.default_rng(0), pinocchio()
    for side in names.SIDES:
        for _ in range(count):
            q, v, a = rng.normal(size=(3, 10)) * [[0.2], [2.0], [20.0]]
            q[[3, 8]] = rng.uniform(0.3, 1.5, 2)
            roll = rng.normal(size=3) * [0.1, 1.0, 5.0]
            yield side, robot.standing(roll, *robot.joint_motion(q, v, a), side)


def test_pinocchio_and_mujoco_agree_on_random_motions_and_impacts():
    """Two dynamics of the prismatic robot, each with its own way to masses, rotors, friction."""
    driven = list(names.ACTUATED)
    for side, state in random_states(10):
        efforts, wrench = pinocchio().inverse_dynamics(state, side)
        forces, jacobian = plant().inverse(plant_state(state), side)
        rest = forces - jacobian.T @ wrench
        np.testing.assert_allclose(rest[:6], 0.0, atol=1e-8)
        np.testing.assert_allclose(rest[6:][driven], efforts, atol=1e-8)
        after = pinocchio().impact(state.q, state.v, side)
        other = plant().impact(plant_state(state), side)
        np.testing.assert_allclose(other[6:], after[6:], atol=1e-9)
        held = pinocchio().jacobian(state.q, side) @ after
        np.testing.assert_allclose(held[[0, 1, 2, 4, 5]], 0.0, atol=1e-9)


@pytest.mark.parametrize("sample", [0, 10, 25, 41])
def test_efforts_through_the_transmission_are_what_mujocos_motors_need(sample):
    """MuJoCo's own transmission: joint efforts of unit motor torques, by its actuator moments."""
    gait, machine = gaits()[1], plant()
    side = names.SIDES[gait.step_of(sample)]
    forces, jacobian = machine.inverse(plant_state(stored_state(gait, pinocchio(), sample)), side)
    model, data = machine.model, machine.data
    moment = np.zeros((model.nu, model.nv))
    mujoco.mj_forward(model, data)
    mujoco.mju_sparse2dense(
        moment, data.actuator_moment, data.moment_rownnz, data.moment_rowadr, data.moment_colind
    )
    motors = Transmission.of(config().robot).torques(gait.efforts[sample])
    made = moment.T @ motors + jacobian.T @ gait.ground_wrench[sample]
    held = np.delete(np.arange(model.nv), [11, 17])  # the upper feet are passive
    np.testing.assert_allclose(made[held], forces[held], atol=1e-6)


def test_the_plant_confirms_a_gait_with_its_own_dynamics_and_not_the_knees():
    own, other = (inverse_dynamics(gait, plant()) for gait in (gaits()[1], knee_gait()))
    assert max(own["plant_force"], own["plant_moment"], own["plant_efforts"]) < 1e-9
    assert other["plant_force"] > 10.0
    assert other["plant_efforts"] > 10.0
    assert 0.2 < own["plant_cop"] < 0.5


def test_stored_states_are_what_mujoco_has():
    gait = gaits()[1]
    (before, after, side), _ = touchdowns(gait, pinocchio())
    half = gait.half
    assert side == "right"
    start = plant_state(before)
    np.testing.assert_allclose(start.qpos[:7], gait.base[half - 1, :7], atol=1e-12)
    np.testing.assert_allclose(start.qpos[7:], gait.samples[half - 1, :12], atol=1e-9)
    np.testing.assert_allclose(start.qvel[:6], gait.base[half - 1, 7:], atol=1e-12)
    np.testing.assert_allclose(plant_state(after).qvel[6:], gait.samples[half, 12:24], atol=1e-9)
