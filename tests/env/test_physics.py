"""Batched physics against MuJoCo's own step, on any number of threads, with blow-ups."""

import mujoco
import numpy as np
import pytest

from slider.env.physics import BatchedPhysics
from slider.env.starts import at_rest
from slider.robot.names import NUM_JOINTS
from slider.robot.transmission import Transmission
from tests.env.synthetic import config, disturbed_physics, make_physics, random_pose, robot_config

START = config("experiment=test").env.start


def random_targets(rng: np.random.Generator, steps: int, count: int) -> np.ndarray:
    lower, upper = robot_config().joint_ranges
    return 0.1 * rng.uniform(lower, upper, (steps, count, NUM_JOINTS))


def test_equals_mujoco_stepped_by_itself():
    rng, physics = np.random.default_rng(1), make_physics(6)
    physics.reset(np.arange(6), *at_rest(robot_config(), START, rng, 6))
    alone = mujoco.MjData(physics.model)
    alone.qpos[:], alone.qvel[:] = physics.qpos[4], physics.qvel[4]
    for targets in random_targets(rng, 15, 6):
        physics.step(targets)
        alone.ctrl[:] = Transmission.of(robot_config()).angles(targets[4])
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
    held.reset(np.arange(3), *at_rest(robot_config(), START, rng, 3))
    last = []
    for targets in random_targets(rng, 5, 3):
        single.reset(np.arange(3), held.qpos, held.qvel)
        held.step(targets)
        parts = []
        for _ in range(4):
            single.step(targets)
            parts.append(single.loads())
        for name in ("power", "effort_share", "speed_share"):
            values = np.array([getattr(part, name) for part in parts])
            expected = values.mean(axis=0) if name == "power" else values.max(axis=0)
            np.testing.assert_allclose(getattr(held.loads(), name), expected, rtol=1e-3)
        last.append(parts[-1].effort_share.max() / held.loads().effort_share.max())
    assert min(last) < 0.8, "the peak is not in the last step"


@pytest.mark.parametrize("actuation", ["position", "torque"])
def test_work_of_the_motors_is_that_of_the_equations_of_motion(actuation):
    """Efforts of motors that differ, by M Δv / h and all other forces, times their displacement."""
    count, rng = 60, np.random.default_rng(5)
    physics = disturbed_physics(
        count, "motor_gain={lower: 0.6, upper: 1.4}", actuation=actuation, substeps=1
    )
    qpos, qvel = random_pose(rng, count)
    physics.reset(np.arange(count), qpos, 4.0 * qvel)
    before = physics.state.copy()
    size = 0.2 if actuation == "position" else 60.0
    inputs = size * rng.standard_normal((count, 12)) * 10.0 ** rng.uniform(-2, 1, (count, 1))
    inputs += qpos[:, 7:] if actuation == "position" else 0.0
    physics.step(inputs)
    found, limits, slowed = physics.loads(), Transmission.of(robot_config()), 0
    control = limits.angles(inputs)
    if actuation == "torque":
        gains = [model.actuator_forcerange[:, 1] / limits.torque for model in physics.models]
        control = limits.torques(inputs) * gains
    for robot, model in enumerate(physics.models):
        data, inertia = mujoco.MjData(model), np.zeros((model.nv, model.nv))
        data.qpos[:], data.qvel[:] = before[robot, 1:20], before[robot, 20:]
        data.ctrl[:] = control[robot]
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, inertia)
        change = physics.qvel[robot] - data.qvel
        force = inertia @ change / model.opt.timestep + model.dof_damping * change
        force -= data.qfrc_passive - data.qfrc_bias + data.qfrc_constraint
        motors = limits.torques(force[6:])
        turned = limits.angles(physics.qvel[robot, 6:])
        power, share = np.abs(motors) @ np.abs(turned), np.abs(motors / limits.torque).max()
        np.testing.assert_allclose(found.power[robot], power, rtol=1e-6)
        np.testing.assert_allclose(found.effort_share[robot], share, rtol=1e-6)
        demanded = physics.read().motor_torques[robot]
        slowed += np.count_nonzero(np.abs(demanded - motors) > 1e-3 * limits.torque)
    assert slowed > count // 2, "demanded torques acted: the test would prove little"


def started(physics: BatchedPhysics) -> BatchedPhysics:
    """One step after a random start."""
    physics.reset(np.arange(4), *random_pose(np.random.default_rng(2), 4))
    physics.step(np.zeros((4, NUM_JOINTS)))
    assert not physics.read().diverged.any()
    return physics


@pytest.mark.parametrize("substeps", [4, 1])
@pytest.mark.parametrize(
    "spoil",
    [
        lambda physics, _: physics.qvel[2, 6:].fill(1e9),
        lambda physics, _: physics.qvel[2, 2:3].fill(1100.0),  # MuJoCo itself would go on
        lambda physics, _: physics.qpos[2, 8:9].fill(np.nan),
        lambda _, targets: targets[2, 3:4].fill(np.nan),
    ],
    ids=["speed", "base", "state", "target"],
)
def test_a_blow_up_is_found_and_stays_alone(spoil, substeps):
    clean, spoiled = (started(make_physics(4, substeps=substeps)) for _ in range(2))
    targets = np.zeros((4, NUM_JOINTS))
    clean.step(targets)
    spoil(spoiled, targets)
    spoiled.step(targets)
    state = spoiled.read()
    np.testing.assert_array_equal(state.diverged, [False, False, True, False])
    others = [0, 1, 3]
    np.testing.assert_array_equal(spoiled.state[others], clean.state[others])
    np.testing.assert_array_equal(spoiled.qpos[2], spoiled.nominal)
    np.testing.assert_array_equal(spoiled.qvel[2], 0.0)
    for _ in range(5):
        spoiled.step(np.zeros((4, NUM_JOINTS)))
    assert np.isfinite(spoiled.qpos).all()
    assert not spoiled.read().diverged.any()


@pytest.mark.parametrize("differ", [False, True])
def test_inactive_robots_stay_and_the_others_go_on(differ):
    """Also where every robot has a model of its own."""
    settings = ["mass.upper=1.3"] if differ else []
    whole, some = both = [started(disturbed_physics(4, *settings)) for _ in range(2)]
    some.deactivate(np.array([False, True, False, True]))
    before = some.state.copy()
    for physics in both:
        for _ in range(3):
            physics.step(np.zeros((4, NUM_JOINTS)))
    np.testing.assert_array_equal(some.qpos[[0, 2]], whole.qpos[[0, 2]])
    np.testing.assert_array_equal(some.read().foot_forces[[0, 2]], whole.read().foot_forces[[0, 2]])
    np.testing.assert_array_equal(some.state[[1, 3], 1:], before[[1, 3], 1:])
    assert not some.read().diverged.any()
    np.testing.assert_array_equal(started(some).qpos, started(whole).qpos, "a reset ends it")
