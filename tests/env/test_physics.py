"""Batched physics against MuJoCo's own step, on any number of threads, with blow-ups."""

# pyright: reportAttributeAccessIssue=false

import mujoco
import numpy as np
import pytest

from slider.env.starts import at_rest, joint_range
from slider.robot.names import NUM_JOINTS
from tests.env.synthetic import (
    SPEED_LIMITS,
    TORQUE_LIMITS,
    config,
    disturbed_physics,
    make_physics,
    motor_angles,
    random_pose,
    robot_config,
)


def random_targets(rng: np.random.Generator, steps: int, count: int) -> np.ndarray:
    lower, upper = joint_range(robot_config())
    return 0.1 * rng.uniform(lower, upper, (steps, count, NUM_JOINTS))


def simulate(threads: int, count: int = 6, steps: int = 15):
    rng = np.random.default_rng(1)
    physics = make_physics(count, threads)
    physics.reset(np.arange(count), *random_pose(rng, count))
    for targets in random_targets(rng, steps, count):
        physics.step(targets)
    return physics


def test_equals_mujoco_stepped_by_itself():
    rng = np.random.default_rng(1)
    physics = make_physics(6)
    noise = config("experiment=test").env.start
    start = at_rest(robot_config(), noise, rng, 6)
    physics.reset(np.arange(6), *start)
    alone = mujoco.MjData(physics.model)
    alone.qpos[:], alone.qvel[:] = start[0][4], start[1][4]
    for targets in random_targets(rng, 15, 6):
        physics.step(targets)
        alone.ctrl[:] = motor_angles(targets[4])
        alone.qacc_warmstart[:] = 0.0  # the rollout keeps no warm start between calls
        for _ in range(4):
            mujoco.mj_step(physics.model, alone)
        np.testing.assert_allclose(physics.qpos[4], alone.qpos, rtol=0, atol=1e-12)
        np.testing.assert_allclose(physics.qvel[4], alone.qvel, rtol=0, atol=1e-11)
    state = physics.read()
    assert state.foot_forces[4].max() > 5.0, "no contact: the comparison would prove little"
    np.testing.assert_allclose(state.motor_torques[4], alone.actuator_force, rtol=0, atol=1e-9)


def test_loads_are_those_of_every_simulation_step():
    """Against the same simulation, looked at after each of its steps."""
    rng = np.random.default_rng(4)
    held, single = make_physics(3), make_physics(3, substeps=1)
    start = at_rest(robot_config(), config("experiment=test").env.start, rng, 3)
    for physics in (held, single):
        physics.reset(np.arange(3), *start)
    last = []
    for targets in random_targets(rng, 5, 3):
        single.reset(np.arange(3), held.qpos, held.qvel)
        held.step(targets)
        torques, speeds = [], []
        for _ in range(4):
            single.step(targets)
            state = single.read()
            torques.append(np.abs(state.motor_torques))
            speeds.append(np.abs(motor_angles(state.joint_velocities)))
        found = held.loads()
        power = np.sum(np.array(torques) * speeds, axis=2).mean(axis=0)
        shares = np.array(torques) / TORQUE_LIMITS, np.array(speeds) / SPEED_LIMITS
        np.testing.assert_allclose(found.power, power, rtol=1e-3)
        np.testing.assert_allclose(found.effort_share, shares[0].max(axis=(0, 2)), rtol=1e-3)
        np.testing.assert_allclose(found.speed_share, shares[1].max(axis=(0, 2)), rtol=1e-3)
        last.append(shares[0][-1].max() / shares[0].max())
    assert min(last) < 0.8, "the peak is not in the last step"


def test_threads_do_not_change_the_result():
    one, three = simulate(1), simulate(3)
    np.testing.assert_array_equal(one.qpos, three.qpos)
    np.testing.assert_array_equal(one.qvel, three.qvel)
    np.testing.assert_array_equal(one.read().foot_forces, three.read().foot_forces)


def spoil_speed(physics, targets):
    physics.qvel[2, 6:] = 1e9


def spoil_base(physics, targets):
    physics.qvel[2, 2] = 1100.0  # MuJoCo itself would go on


def spoil_state(physics, targets):
    physics.qpos[2, 8] = np.nan


def spoil_target(physics, targets):
    targets[2, 3] = np.nan


@pytest.mark.parametrize("substeps", [4, 1])
@pytest.mark.parametrize("spoil", [spoil_speed, spoil_base, spoil_state, spoil_target])
def test_a_blow_up_is_found_and_stays_alone(spoil, substeps):
    start = random_pose(np.random.default_rng(2), 4)
    clean, spoiled = make_physics(4, substeps=substeps), make_physics(4, substeps=substeps)
    for physics in (clean, spoiled):
        physics.reset(np.arange(4), *start)
        physics.step(np.zeros((4, NUM_JOINTS)))
        assert not physics.read().diverged.any()
    targets = np.zeros((4, NUM_JOINTS))
    clean.step(targets)
    spoil(spoiled, targets)
    spoiled.step(targets)
    state = spoiled.read()
    np.testing.assert_array_equal(state.diverged, [False, False, True, False])
    others = [0, 1, 3]
    np.testing.assert_array_equal(spoiled.qpos[others], clean.qpos[others])
    np.testing.assert_array_equal(spoiled.qvel[others], clean.qvel[others])
    np.testing.assert_array_equal(spoiled.qpos[2], spoiled.nominal)
    np.testing.assert_array_equal(spoiled.qvel[2], 0.0)
    for _ in range(5):
        spoiled.step(np.zeros((4, NUM_JOINTS)))
    assert np.isfinite(spoiled.qpos).all()
    assert not spoiled.read().diverged.any()


@pytest.mark.parametrize("differ", [False, True])
def test_retired_robots_stay_and_the_others_go_on(differ):
    """Also where every robot has a model of its own."""
    start = random_pose(np.random.default_rng(2), 4)
    both = [disturbed_physics(4, "mass.upper=1.3") if differ else make_physics(4) for _ in range(2)]
    for physics in both:
        physics.reset(np.arange(4), *start)
        physics.step(np.zeros((4, NUM_JOINTS)))
    whole, some = both
    some.retire(np.array([False, True, False, True]))
    before = some.state.copy()
    for physics in both:
        for _ in range(3):
            physics.step(np.zeros((4, NUM_JOINTS)))
    np.testing.assert_array_equal(some.qpos[[0, 2]], whole.qpos[[0, 2]])
    np.testing.assert_array_equal(some.read().foot_forces[[0, 2]], whole.read().foot_forces[[0, 2]])
    np.testing.assert_array_equal(some.state[[1, 3], 1:], before[[1, 3], 1:])
    assert not some.read().diverged.any()
    some.reset(np.arange(4), *start)
    whole.reset(np.arange(4), *start)
    for physics in both:
        physics.step(np.zeros((4, NUM_JOINTS)))
    if not differ:  # else they are drawn anew
        np.testing.assert_array_equal(some.qpos, whole.qpos)
    assert (some.qpos[1] != start[0][1]).any()
