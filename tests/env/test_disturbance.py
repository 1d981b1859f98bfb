"""Pushes, delays, seeds and noise of the sensors; nothing happens where nothing is asked for."""

from dataclasses import fields

import numpy as np
import pytest
import torch

from slider.config.env import SensingConfig
from slider.config.types import Interval
from slider.env.disturbance import (
    NOISE,
    PUSH,
    DelayLine,
    Disturbance,
    DisturbanceModel,
    SeededRandom,
    with_noise,
)
from slider.env.starts import NUMPY
from slider.env.state import RobotState
from slider.robot import names
from tests.env.synthetic import (
    JOINTS,
    disturbance,
    disturbed_physics,
    make_arrays,
    make_physics,
    momentum,
    robot_config,
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
    "payload={lower: 0.0, upper: 2.0}",
    "push={impulse: {lower: 6.5, upper: 6.5}, duration: 0.04, interval: 0.1}",
    "terrain={kinds: [tiles], level: {lower: 2.0, upper: 3.0}}",
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


def test_a_push_is_a_force_for_a_while_at_regular_times():
    push = Disturbance(
        disturbance("push={impulse: {lower: 2.0, upper: 6.0}, duration: 0.04}"), (1,)
    )
    disturber = DisturbanceModel(push, robot_config(), make_physics(1).model, "position", 200)
    disturber.begin(np.arange(200), make_physics(200).qpos)
    forces = []
    for _ in range(305):  # control steps of 20 ms
        forces.append(disturber.push().copy())
        disturber.drive(np.zeros((200, 4, 10)))
    impulses = np.linalg.norm(forces, axis=2) * 0.04
    pushed = np.flatnonzero(impulses.any(axis=1))
    np.testing.assert_array_equal(pushed, [150, 151, 300, 301])
    np.testing.assert_array_equal(forces[150], forces[151])
    assert 2.0 <= impulses[pushed].min() < 2.2
    assert 5.8 < impulses.max() <= 6.0
    assert np.abs(np.array(forces[150]) - forces[300]).max() > 10.0, "every push is another one"
    angle = np.arctan2(*forces[150].T)
    assert np.histogram(angle, 4, (-np.pi, np.pi))[0].min() > 30, "in all directions"


@pytest.mark.parametrize("actuation", ["position", "torque"])
def test_a_push_gives_a_robot_in_the_air_its_impulse(actuation):
    push = "push={impulse: {lower: 4.0, upper: 4.0}, duration: 0.06, interval: 0.1, direction: 0.5}"
    physics = disturbed_physics(3, push, actuation=actuation)
    qpos = np.tile(physics.nominal, (3, 1))
    qpos[:, 2] += 2.0
    physics.reset(np.arange(3), qpos, np.zeros((3, 18)))
    for _ in range(9):
        physics.step(np.zeros((3, names.NUM_JOINTS)))
    expected = 4.0 * np.array([[np.cos(0.5), np.sin(0.5)]] * 3)
    np.testing.assert_allclose(momentum(physics)[:, :2], expected, rtol=0.01)


def test_nothing_asked_for_is_bit_identical_to_no_disturbance():
    plain, off = make_physics(COUNT), disturbed_physics(COUNT)
    np.testing.assert_array_equal(run(plain), run(off))
    state = off.read()
    assert off.measure(state) is state
    np.testing.assert_array_equal(plain.masses, off.masses)


def test_a_restart_brings_the_same_disturbances_back():
    physics = disturbed_physics(COUNT, *EVERYTHING)
    first = run(physics)
    physics.restart_disturbances()
    np.testing.assert_array_equal(run(physics), first)
    assert np.abs(run(physics) - first).max() > 1e-3, "and another episode is another one"


def test_one_disturbance_does_not_move_the_draws_of_another():
    alone = stand(disturbed_physics(COUNT, "mass={lower: 0.9, upper: 1.1}"))
    together = stand(disturbed_physics(COUNT, *EVERYTHING))
    legs = [[model.body_mass[2:] for model in physics.models] for physics in (alone, together)]
    np.testing.assert_array_equal(*legs)


@pytest.mark.parametrize("substeps", [1, 4])
@pytest.mark.parametrize("least", [0, 1])
def test_each_robots_inputs_are_late_by_its_own_delay_at_any_rate_of_the_controller(
    substeps, least
):
    """Whole simulation steps, from the shortest to the longest."""
    count = 7 - least
    every, line = np.arange(count), DelayLine(Interval(0.005 * least, 0.03), 0.005, count, 1)
    line.draw(every, (every + 0.5) / count)
    line.fill(every, np.full((count, 1), -1.0))
    issued = np.repeat(np.arange(24 // substeps), substeps).astype(float)
    calls = np.tile(issued.reshape(-1, 1, substeps, 1), (1, count, 1, 1))
    arrived = np.concatenate([line.pass_on(call)[..., 0] for call in calls], axis=1)
    for late, row in enumerate(arrived, least):
        np.testing.assert_array_equal(row, np.concatenate([[-1.0] * late, issued])[:24])


@pytest.mark.parametrize("kind", ["uniform", "normal"])
@pytest.mark.parametrize("like", [NUMPY, torch.zeros(0)], ids=["numpy", "torch"])
def test_a_block_of_robots_depends_on_its_own_seed_use_and_time_only(like, kind):
    def draw(seeds: tuple[int, ...], count: int, use: int = PUSH, time: int = 7) -> np.ndarray:
        values = getattr(SeededRandom(seeds, count, like), kind)(use, time, 4)
        assert values.dtype == like.dtype
        return np.array(values)

    many = draw((3,), 4000)
    mean, spread = (0.5, 12**-0.5) if kind == "uniform" else (0.0, 1.0)
    assert (many.mean(), many.std()) == (pytest.approx(mean, abs=0.02), pytest.approx(spread, 0.03))
    both = draw((1, 2), 6)
    np.testing.assert_array_equal(both[3:], draw((2,), 3))
    np.testing.assert_array_equal(both, draw((1, 2), 6))
    others = draw((1,), 3), draw((2,), 3, time=8), draw((2,), 3, use=NOISE)
    assert all((both[3:] != other).all() for other in others)


SILENT = {item.name: 0.0 for item in fields(SensingConfig)}
SLIDES = np.array([name.endswith("slide") for name in JOINTS])
VALUES = {
    "joint_position": lambda s: s.joint_positions[:, ~SLIDES],
    "slide_position": lambda s: s.joint_positions[:, SLIDES],
    "joint_velocity": lambda s: s.joint_velocities[:, ~SLIDES],
    "slide_velocity": lambda s: s.joint_velocities[:, SLIDES],
    "angular_velocity": lambda s: s.angular_velocity,
    "orientation": lambda s: np.stack([s.gravity[:, 1], -s.gravity[:, 0], -s.yaw], axis=1),
    "linear_velocity": lambda s: s.linear_velocity,
    "base_height": lambda s: s.base_height,
}


def measured(**noise: float) -> RobotState:
    """The measured state of robots at rest."""
    normal = np.random.default_rng(0).standard_normal((4000, 34))
    return with_noise(make_arrays(4000), SensingConfig(**{**SILENT, **noise}), normal)


@pytest.mark.parametrize("quantity", VALUES)
def test_standard_deviation_of_one_quantity_and_none_of_the_others(quantity):
    true, noisy = make_arrays(4000), measured(**{quantity: 0.02})
    errors = {name: value(noisy) - value(true) for name, value in VALUES.items()}
    found = errors.pop(quantity)
    np.testing.assert_allclose(found.std(axis=0), 0.02, rtol=0.06)
    np.testing.assert_allclose(found.mean(axis=0), 0.0, atol=0.0015)
    for name, error in errors.items():
        np.testing.assert_allclose(error, 0.0, atol=1e-12, err_msg=name)


def test_the_orientation_is_one_whoever_looks_at_it():
    """Heading, gravity, rotation and MuJoCo's coordinates agree."""
    noisy = measured(orientation=0.05, linear_velocity=0.1)
    np.testing.assert_allclose(np.linalg.norm(noisy.quaternion, axis=1), 1.0)
    np.testing.assert_allclose(-noisy.rotation[:, 2], noisy.gravity)
    x, y = noisy.qvel[:, :2].T
    ahead, left = np.cos(noisy.yaw), np.sin(noisy.yaw)
    expected = np.stack([x * ahead + y * left, y * ahead - x * left], axis=1)
    np.testing.assert_allclose(noisy.heading_velocity, expected, atol=1e-12)


def test_the_noise_of_an_instant_is_the_same_at_every_control_rate():
    slow, fast = (
        stand(disturbed_physics(3, "sensing.joint_velocity=0.2", substeps=substeps), 0.1)
        for substeps in (4, 1)
    )
    first = rate_noise(slow)
    np.testing.assert_allclose(first, rate_noise(fast), atol=1e-12)
    np.testing.assert_array_equal(rate_noise(slow), first)
    slow.step(np.zeros((3, names.NUM_JOINTS)))
    assert not np.isclose(rate_noise(slow), first).any()


def rate_noise(physics) -> np.ndarray:
    """Error of the measured speeds of the hinges (N, 10) [rad/s]."""
    true = physics.read()
    return (physics.measure(true).joint_velocities - true.joint_velocities)[:, ~SLIDES]
