"""The entry's references are those of the pendulum; its exit depends on the state."""

from dataclasses import replace

import numpy as np
import pytest

from slider.control.whole_body import references
from slider.control.whole_body.entry import Entry
from tests.env.synthetic import config

OMEGA, TUNED = references.natural_frequency(0.65), config().control["mpc_wbc_tuned"]
MIDDLE, REACH = np.zeros((1, 2)), 0.085


def entry(**changes) -> Entry:
    return Entry(TUNED.step, replace(TUNED.entry, **changes), OMEGA, REACH)


def begin(case: Entry, side: float = 1.0, speed: float = 0.0, elapsed: float = 0.0):
    sway = case.begin(MIDDLE, np.zeros((1, 2)), np.array([side]), np.array([speed]))
    sway.elapsed[:] = elapsed
    return sway


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_ends_in_the_middle_with_the_orbits_speed_towards_the_stance_foot(side):
    case = entry()
    reference = case.reference(begin(case, side, elapsed=TUNED.entry.duration))
    speed = references.lateral_end_velocity(OMEGA, TUNED.step.time, TUNED.step.width)
    np.testing.assert_allclose(reference[0, 1], [0.0, side * speed, 0.0], atol=1e-12)


def test_pushes_forward_as_a_pendulum_does_and_never_beyond_the_foot():
    case, duration = entry(push=0.08), TUNED.entry.duration
    slow = case.reference(begin(case, speed=0.2, elapsed=duration))[0, 0]
    after_a_step = references.step_map(OMEGA, TUNED.step.time) @ slow[:2]
    expected = references.forward_end_velocity(OMEGA, TUNED.step.time, np.array(0.2))
    assert after_a_step[1] == pytest.approx(float(expected))
    fast = case.reference(begin(case, speed=3.0, elapsed=duration))[0, 0]
    state = references.step_map(OMEGA, duration) @ [0.08, 0.0]
    np.testing.assert_allclose(fast[:2], state - [0.08, 0.0])
    np.testing.assert_allclose(fast[2], OMEGA**2 * (fast[0] + 0.08))
    still = entry(push=0.0)
    assert not still.reference(begin(still, speed=3.0, elapsed=duration))[0, 0].any()


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_leaves_when_the_pendulum_has_the_energy_and_the_direction(side):
    case, foot = entry(tolerance=0.0), np.array([[0.0, side * TUNED.step.width / 2]])
    sway = begin(case, side, elapsed=0.9 * TUNED.entry.duration)
    speed = references.lateral_end_velocity(OMEGA, TUNED.step.time, TUNED.step.width)

    def done(velocity: float, forward: float = 0.0) -> bool:
        return bool(case.done(sway, MIDDLE, np.array([[forward, side * velocity]]), foot)[0])

    assert done(1.01 * speed)
    assert not done(0.5 * speed)
    assert not done(-1.01 * speed)
    assert not done(1.01 * speed, forward=2 * TUNED.entry.speed_tolerance)


def test_out_of_time_it_sways_again_or_steps_where_it_cannot_stop():
    case, foot = entry(), np.array([[0.0, 0.1]])
    late = TUNED.entry.duration + TUNED.entry.patience + 0.01
    sway = begin(case, speed=1.0, elapsed=late)
    position, slow, fast = np.array([[0.02, 0.01]]), np.array([[0.1, 0.0]]), np.array([[0.5, 0.0]])
    assert case.done(sway, position, fast, foot)[0]
    assert not case.done(sway, position, slow, foot)[0]
    case.restart(sway, position, slow)
    assert sway.elapsed[0] == 0.0
    np.testing.assert_allclose(case.reference(sway)[0, :, 0], [0.0, 0.01])
