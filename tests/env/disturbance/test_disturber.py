"""Pushes, seeds, and that nothing happens where nothing is asked for."""

# pyright: reportAttributeAccessIssue=false

from collections import defaultdict
from typing import Any

import mujoco
import numpy as np
import pytest

from slider.core.arrays import asarray
from slider.env.disturbance import Disturbance, Disturber, Draws
from slider.env.interface import FLOAT64
from slider.env.randomization import drawn
from slider.env.starts import NUMPY
from slider.robot import names
from slider.robot.mjcf import Actuation
from tests.env.synthetic import (
    config,
    disturbed_physics,
    make_arrays,
    make_physics,
    random_pose,
    stand,
)

COUNT = 6
EVERYTHING = (
    "sensing.joint_position=0.005",
    "sensing.orientation=0.02",
    "delay={lower: 0.0, upper: 0.03}",
    "motor_gain={lower: 0.9, upper: 1.1}",
    "mass={lower: 0.9, upper: 1.1}",
    "centre_of_mass=0.02",
    "friction={lower: 0.5, upper: 1.2}",
    "push={speed: 0.5, interval: 0.1}",
    "ground.amplitude=0.01",
)


def run(physics, steps: int = 12) -> np.ndarray:
    """Measured positions and velocities of some steps (steps, N, 37)."""
    rng = np.random.default_rng(1)
    stand(physics)
    rows = []
    for _ in range(steps):
        physics.step(0.05 * rng.standard_normal((physics.num_robots, names.NUM_JOINTS)))
        state = physics.measure(physics.read())
        rows.append(np.concatenate([state.qpos, state.qvel], axis=1))
    return np.stack(rows)


def make_disturber(
    count: int,
    *settings: str,
    actuation: Actuation = "position",
    robots: Any = None,
    like: Any = NUMPY,
) -> Disturber:
    whole = config("experiment=test", *(f"evaluation.disturbance.{text}" for text in settings))
    disturbance = Disturbance(whole.evaluation.disturbance, (1,))
    model = make_physics(1).model
    return Disturber(disturbance, whole.robot, model, actuation, count, robots, like)


class Gains:
    """Robots of which only the motors are asked."""

    def __init__(self, like: Any) -> None:
        self.motor_gain = asarray(np.ones((COUNT, len(names.MOTORS))), like)
        self.masses = self.motor_gain.sum(axis=1)

    def draw(self, index: Any, uniform: Any) -> None:
        settings = config(f"evaluation.disturbance.{EVERYTHING[3]}").evaluation.disturbance
        self.motor_gain[index] = drawn(settings, uniform[index]).gain


class Numbers(Draws):
    """Those of NumPy, as tensors."""

    def uniform(self, use: int, time: int, columns: int) -> Any:
        return asarray(super().uniform(use, time, columns), FLOAT64)

    def normal(self, use: int, time: int, columns: int) -> Any:
        return asarray(super().normal(use, time, columns), FLOAT64)


def disturb(disturber: Disturber, like: Any) -> dict[str, list[Any]]:
    """What a disturber makes of positions, velocities, inputs and states; some begin anew."""
    rng, some = np.random.default_rng(2), np.arange(0, COUNT, 2)
    qpos, qvel = (asarray(values, like) for values in random_pose(rng, COUNT))
    control = asarray(rng.standard_normal((14, COUNT, 4, len(names.MOTORS))), like)
    state = make_arrays(COUNT)
    state = state if like is NUMPY else state.tensors(like)
    disturber.restart()
    found = defaultdict(list, begun=[disturber.begin(np.arange(COUNT), qpos)])
    for step in range(14):
        if step == 3:
            found["begun"].append(disturber.begin(some, qpos[some]))
        pushed = 1.0 * qvel
        disturber.push(pushed)
        found["pushed"].append(pushed)
        found["driven"].append(disturber.drive(control[step]))
        seen = disturber.measure(state)
        found["seen"] += [seen.qpos, seen.qvel]
    return found


@pytest.mark.parametrize("actuation", ["position", "torque"])
def test_arrays_and_tensors_are_disturbed_alike_by_the_same_numbers(actuation: Actuation):
    """Drives, pushes, delays and noise."""
    arrays, tensors = (
        make_disturber(COUNT, *EVERYTHING[:-1], actuation=actuation, robots=Gains(like), like=like)
        for like in (NUMPY, FLOAT64)
    )
    tensors._draws = Numbers((1,), COUNT)
    expected = disturb(arrays, NUMPY)
    found = disturb(tensors, FLOAT64)
    for name, values in expected.items():
        for one, other in zip(found[name], values, strict=True):
            np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-12, err_msg=name)
    pushed = np.stack(expected["pushed"])
    first = (pushed != pushed[0]).any(axis=2).argmax(axis=0)
    np.testing.assert_array_equal(first, [8, 5] * (COUNT // 2), "those that begin anew wait longer")
    assert len(set(arrays._delay.steps.tolist())) > 2, "delays do not differ"


def test_a_push_changes_the_velocity_of_the_base_once_per_interval():
    physics, disturber = make_physics(200), make_disturber(200, "push={speed: 0.5, interval: 0.1}")
    disturber.begin(np.arange(200), physics.qpos)
    change = np.zeros((200, 18))
    for _ in range(5):
        disturber.push(change)
        assert not change.any()
        disturber.drive(np.zeros((200, 4, 10)))  # 20 ms
    disturber.push(change)
    np.testing.assert_allclose(np.linalg.norm(change[:, :2], axis=1), 0.5)
    assert not change[:, 2:].any()
    angle = np.arctan2(change[:, 1], change[:, 0])
    assert np.histogram(angle, 4, (-np.pi, np.pi))[0].min() > 30, "in all directions"


def test_a_push_gives_the_whole_robot_momentum():
    """The legs keep their joint speeds: all of the mass is faster by 0.5 m/s at first."""
    physics = stand(make_physics(1), 0.1)
    before = momentum(physics)
    physics.qvel[0, :2] += [0.3, -0.4]
    gained = momentum(physics) - before
    np.testing.assert_allclose(gained, physics.masses[:, None] * [[0.3, -0.4]], atol=1e-9)


def momentum(physics) -> np.ndarray:
    """Horizontal momentum (N, 2) [kg m/s]."""
    data = mujoco.MjData(physics.model)
    result = []
    for qpos, qvel, mass in zip(physics.qpos, physics.qvel, physics.masses, strict=True):
        data.qpos[:], data.qvel[:] = qpos, qvel
        mujoco.mj_forward(physics.model, data)
        mujoco.mj_subtreeVel(physics.model, data)
        result.append(mass * data.subtree_linvel[1, :2])
    return np.array(result)


def test_pushes_come_at_their_times_and_not_before():
    rows = run(disturbed_physics(50, "push={speed: 0.5, interval: 0.1}"), 6)
    calm = run(disturbed_physics(50), 6)
    np.testing.assert_array_equal(rows[:5], calm[:5])
    speed = np.linalg.norm(rows[5, :, 19:21] - calm[5, :, 19:21], axis=1)
    assert (speed > 0.1).all()


def test_nothing_asked_for_is_bit_identical_to_no_disturbance():
    plain, off = make_physics(COUNT), disturbed_physics(COUNT)
    start = random_pose(np.random.default_rng(0), COUNT)
    for physics in (plain, off):
        physics.reset(np.arange(COUNT), *start)
    for k in range(20):
        inputs = 0.05 * np.random.default_rng(k).standard_normal((COUNT, names.NUM_JOINTS))
        plain.step(inputs), off.step(inputs)
        np.testing.assert_array_equal(plain.qpos, off.qpos)
        np.testing.assert_array_equal(plain.qvel, off.qvel)
    state = off.read()
    assert off.measure(state) is state
    np.testing.assert_array_equal(plain.masses, off.masses)


def test_the_seed_decides():
    one, same = (run(disturbed_physics(COUNT, *EVERYTHING)) for _ in range(2))
    other = run(disturbed_physics(COUNT, *EVERYTHING, seeds=(2,)))
    np.testing.assert_array_equal(one, same)
    assert (np.abs(one - other).max(axis=(0, 2)) > 1e-3).all()


def test_a_restart_brings_the_same_disturbances_back():
    physics = disturbed_physics(COUNT, *EVERYTHING)
    first = run(physics)
    physics.restart_disturbances()
    np.testing.assert_array_equal(run(physics), first)
    assert np.abs(run(physics) - first).max() > 1e-3, "and another episode is another one"


def test_a_block_of_robots_depends_on_its_own_seed_only():
    """So trial k is the same however many trials there are."""
    settings = EVERYTHING[:-1]  # the ground is that of the first seed
    both = run(disturbed_physics(COUNT, *settings, seeds=(1, 2)))
    second = run(disturbed_physics(COUNT // 2, *settings, seeds=(2,)), 0 + 12)
    masses = disturbed_physics(COUNT, *settings, seeds=(1, 2))
    alone = disturbed_physics(COUNT // 2, *settings, seeds=(2,))
    stand(masses), stand(alone)
    np.testing.assert_array_equal(masses.masses[COUNT // 2 :], alone.masses)
    assert both.shape[1] == 2 * second.shape[1]


def test_one_disturbance_does_not_move_the_draws_of_another():
    alone = stand(disturbed_physics(COUNT, "mass={lower: 0.9, upper: 1.1}"))
    together = stand(disturbed_physics(COUNT, *EVERYTHING))
    np.testing.assert_array_equal(alone.masses, together.masses)


def test_robust_is_what_the_issue_lists():
    robust = config("evaluation=robust").evaluation.disturbance
    assert (robust.delay.lower, robust.delay.upper) == (0.02, 0.02)
    for interval in (robust.mass, robust.motor_gain):
        assert (interval.lower, interval.upper) == (0.9, 1.1)
    assert robust.centre_of_mass == 0.02
    assert robust.friction is not None
    assert (robust.friction.lower, robust.friction.upper) == (0.5, 1.2)
    assert (robust.push.speed, robust.push.interval) == (0.5, 3.0)
