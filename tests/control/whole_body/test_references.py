"""The pendulum by its integral, quintics, and an entry that ends by the state."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from slider.control.whole_body import references
from slider.control.whole_body.memory import Orbit
from slider.control.whole_body.references import Entry, quintic
from tests.env.synthetic import config

OMEGA = references.natural_frequency(0.65)
TUNED = config().control["mpc_wbc_tuned"]
MIDDLE, REACH = np.zeros((1, 2)), 0.085
APART, STEP = 0.1, TUNED.step  # half of the distance of the feet [m]
FEET = np.array([[[0.0, APART], [0.0, -APART]]])


@pytest.mark.parametrize("state", [(0.1, -0.3), (-0.12, 0.7)])
def test_step_map_is_the_integral_of_the_pendulum(state):
    found = references.step_map(OMEGA, 0.37) @ state
    path = solve_ivp(lambda t, x: [x[1], OMEGA**2 * x[0]], (0, 0.37), state, rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(found, path.y[:, -1], rtol=1e-8)


def test_quintic_meets_its_ends_and_its_rates_are_derivatives():
    rng = np.random.default_rng(0)
    start, end = rng.normal(size=(4, 3)), rng.normal(size=(4, 3))
    duration = rng.uniform(0.2, 0.6, 4)
    np.testing.assert_allclose(quintic(start, end, duration, 0.0), start, atol=1e-12)
    np.testing.assert_allclose(quintic(start, end, duration, duration), end, atol=1e-9)
    eps, time = 1e-6, 0.13
    before, after = (quintic(start, end, duration, time + s * eps) for s in (-1, 1))
    slope = (after - before)[:, :2] / (2 * eps)
    np.testing.assert_allclose(slope, quintic(start, end, duration, time)[:, 1:], rtol=1e-5)


def entry(**changes) -> Entry:
    return Entry(replace(TUNED.entry, **changes), OMEGA, REACH)


def begin(
    case: Entry,
    side: float = 1.0,
    speed: float = 0.0,
    elapsed: float = 0.0,
    end: float = STEP.width / 2,
    ahead: float = 0.0,
):
    orbit, place = Orbit(np.array([end]), np.array([STEP.time])), np.array([[ahead, 0.0]])
    sway = case.begin(FEET, place, np.array([side]), np.array([speed]), orbit)
    sway.elapsed[:] = elapsed
    return sway


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("orbit", [APART, 0.15, 0.075, 0.0])
def test_a_step_from_the_middle_ends_as_far_from_its_foot_as_the_orbits_steps(side, orbit):
    """Where these are not known (0) the feet stay as far apart as they are."""
    case = entry()
    reference = case.reference(begin(case, side, elapsed=TUNED.entry.duration, end=orbit))
    place, speed, _ = side * reference[0, 1]
    assert place == pytest.approx(0.0, abs=1e-12)
    end = references.step_map(OMEGA, STEP.time) @ [place - APART, speed]
    assert end[0] == pytest.approx(-(orbit or APART))
    if orbit in (APART, 0.0):  # the feet are as far apart as in the orbit
        expected = references.lateral_end_velocity(OMEGA, STEP.time, 2 * APART)
        assert speed == pytest.approx(float(expected))


@pytest.mark.parametrize("ahead", [0.0, 0.02, -0.02])
def test_pushes_forward_as_a_pendulum_does_in_the_middle_and_starts_where_it_is(ahead):
    case, duration = entry(push=0.08), TUNED.entry.duration
    assert case.reference(begin(case, speed=0.2, ahead=ahead))[0, 0, 0] == pytest.approx(ahead)
    slow = case.reference(begin(case, speed=0.2, ahead=ahead, elapsed=duration))[0, 0]
    after_a_step = references.step_map(OMEGA, STEP.time) @ slow[:2]
    expected = references.forward_end_velocity(OMEGA, STEP.time, np.array(0.2))
    assert after_a_step[1] == pytest.approx(float(expected))


def test_never_pushes_further_than_it_may():
    case, duration = entry(push=0.08), TUNED.entry.duration
    fast = case.reference(begin(case, speed=3.0, elapsed=duration))[0, 0]
    state = references.step_map(OMEGA, duration) @ [0.08, 0.0]
    np.testing.assert_allclose(fast[:2], state - [0.08, 0.0])
    np.testing.assert_allclose(fast[2], OMEGA**2 * (fast[0] + 0.08))
    still = entry(push=0.0)
    assert not still.reference(begin(still, speed=3.0, elapsed=duration))[0, 0].any()


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_leaves_when_a_step_leads_into_the_orbit(side):
    case, foot = entry(tolerance=0.0), np.array([[0.0, side * APART]])
    sway = begin(case, side, elapsed=0.9 * TUNED.entry.duration, end=APART)
    speed = references.lateral_end_velocity(OMEGA, STEP.time, 2 * APART)

    def done(velocity: float, forward: float = 0.0) -> bool:
        return bool(case.done(sway, MIDDLE, np.array([[forward, side * velocity]]), foot)[0])

    assert done(1.01 * speed)
    assert not done(0.5 * speed)
    assert not done(-1.01 * speed)
    assert not done(1.01 * speed, forward=2 * TUNED.entry.speed_tolerance)


def test_steps_at_once_where_the_capture_point_is_far_off_the_plan():
    case, foot, still = entry(push=0.08), np.array([[0.0, APART]]), np.zeros((1, 2))
    sway = begin(case, speed=1.0, elapsed=0.9 * TUNED.entry.duration)
    place, speed, _ = case.reference(sway)[0, 0]
    ahead = np.array([[place, 0.0]]), np.array([[speed, 0.0]])
    assert place + speed / OMEGA > REACH
    assert not case.done(sway, *ahead, foot)[0]
    assert case.done(sway, np.array([[-0.02, 0.0]]), still, foot)[0]


@pytest.mark.parametrize("ahead", [-0.08, 0.0, 0.11])
@pytest.mark.parametrize("push", [0.0, 0.08])
def test_at_rest_above_its_feet_it_does_not_step_at_once(ahead, push):
    case, foot = entry(push=push), np.array([[0.0, APART]])
    place, still = np.array([[ahead, 0.0]]), np.zeros((1, 2))
    assert not case.done(begin(case, speed=0.4, ahead=ahead), place, still, foot)[0]


def test_out_of_time_it_sways_again_or_steps_where_it_cannot_stop():
    case, foot = entry(push=0.0), np.array([[0.0, 0.1]])
    late = TUNED.entry.duration + TUNED.entry.patience + 0.01
    sway = begin(case, speed=1.0, elapsed=late)
    position, slow, fast = np.array([[0.02, 0.01]]), np.array([[0.1, 0.0]]), np.array([[0.5, 0.0]])
    assert case.done(sway, position, fast, foot)[0]
    assert not case.done(sway, position, slow, foot)[0]
    case.restart(sway, position, slow)
    assert sway.elapsed[0] == 0.0
    np.testing.assert_allclose(case.reference(sway)[0, :, 0], [0.02, 0.01])
    assert not case.done(sway, position, slow, foot)[0]
