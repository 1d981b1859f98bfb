"""The planner's prediction against the pendulum, its fixed point and its optimality."""

from dataclasses import replace

import numpy as np
import pytest

from slider.control.footsteps import FootstepPlanner, Pendulum
from slider.control.whole_body import references
from tests.env.synthetic import config

OMEGA = references.natural_frequency(0.65)
TUNED = config().control["mpc_wbc_tuned"]
STEP = replace(TUNED.step, time=0.3, time_per_speed=0.0, width=0.2, apex=0.07)
TIME = STEP.time


def planner(step: dict | None = None, **changes) -> FootstepPlanner:
    settings = replace(TUNED.planner, **{"steps": 3, "time_weight": 50.0} | changes)
    return FootstepPlanner(replace(STEP, **(step or {})), settings, OMEGA)


def pendulum(position, velocity, target=(0.0, 0.0)) -> Pendulum:
    """On the left foot, 0.1 s into a step."""
    values = (position, velocity, -1.0, 0.1, TIME, target)
    return Pendulum(*(np.array([value], dtype=float) for value in values))


def on_orbit(case: FootstepPlanner, velocity: np.ndarray | list, elapsed: float) -> Pendulum:
    """Walking on the left foot, right foot in the air, exactly on both orbits."""
    mean = np.array(velocity)
    time = case.nominal_time(mean)
    start = np.stack([-mean * time[:, None] / 2, mean])
    start[1] = references.forward_end_velocity(OMEGA, time[:, None], mean)
    start[0, :, 1] -= STEP.width / 2
    start[1, :, 1] += references.lateral_end_velocity(OMEGA, time, STEP.width)
    position, rate = np.einsum("ij,jna->ina", references.step_map(OMEGA, elapsed), start)
    ones = np.ones(len(mean))
    return Pendulum(position, rate, -ones, elapsed * ones, time, mean)


@pytest.mark.parametrize("elapsed", [0.0, 0.13, 0.2])
def test_orbits_are_fixed_points_whose_nominal_duration_grows_with_the_speed(elapsed):
    """Robots of one batch have durations of their own."""
    case = planner(step={"time": 0.25, "time_per_speed": 0.05})
    every = np.array([[0.0, 0.0], [-1.0, 0.1], [2.0, 0.0], [9.0, 0.0]])
    np.testing.assert_allclose(case.nominal_time(every), [0.25, 0.3, 0.35, STEP.time_max])
    now = on_orbit(case, every[:3], elapsed)
    plan = case.plan(now)
    expected = now.reference_velocity * now.duration[:, None] - [0.0, STEP.width]
    np.testing.assert_allclose(plan.step, expected, atol=1e-9)
    np.testing.assert_allclose(plan.duration, now.duration)
    np.testing.assert_allclose(plan.cost, 0.0, atol=1e-10)


def velocities(start: np.ndarray, remaining: float, lengths: np.ndarray) -> np.ndarray:
    """Velocities at the ends of the steps, step by step."""
    state, found = references.step_map(OMEGA, remaining) @ start, []
    for length in lengths:
        state = references.step_map(OMEGA, TIME) @ (state - [length, 0.0])
        found.append(state[1])
    return np.array(found)


def cost(case: FootstepPlanner, now: Pendulum, lengths: np.ndarray, remaining: float) -> float:
    speeds, nominal, _, _ = case.references(now)
    total = 0.0
    for axis in (0, 1):
        start = np.array([now.position[0, axis], now.velocity[0, axis]])
        error = velocities(start, remaining, lengths[axis]) - speeds[0, axis]
        total += (error**2).sum()
        total += 0.05 * ((lengths[axis] - nominal[0, axis]) ** 2).sum()
    return total


@pytest.mark.parametrize("seed", range(4))
def test_plans_are_optimal_within_their_bounds(seed):
    """Cost from the pendulum itself; no feasible change of the lengths is cheaper."""
    rng = np.random.default_rng(seed)
    case = planner(length_weight=0.05)
    now = pendulum(rng.normal(0, 0.15, 2), rng.normal(0, 0.8, 2), (0.9, 0.1))
    lengths, found = case.solve(now, np.array([0.2]))
    assert found[0] == pytest.approx(cost(case, now, lengths[0], 0.2), rel=1e-9)
    _, _, lower, upper = case.references(now)
    assert (lengths >= lower - 1e-9).all()
    assert (lengths <= upper + 1e-9).all()
    for _ in range(200):
        other = np.clip(lengths[0] + rng.normal(0, 0.02, (2, 3)), lower[0], upper[0])
        assert cost(case, now, other, 0.2) >= found[0] - 1e-9


def test_feet_never_cross():
    """Even where the body falls to the outside of the stance foot."""
    case = planner(width_min=0.11)
    now = pendulum((0.0, 0.05), (0.0, 0.6))
    lengths, _ = case.solve(now, np.array([0.2]))
    np.testing.assert_array_equal(np.sign(lengths[0, 1]), [-1, 1, -1])
    assert lengths[0, 1, 0] == pytest.approx(-0.11)


def test_step_time_adapts_where_that_pays_and_stays_in_range():
    now = on_orbit(planner(), [[0.8, 0.0]], 0.1)
    late = pendulum(now.position[0], now.velocity[0] + [0.0, -0.3], (0.8, 0.0))
    plan = planner(time_weight=0.0).plan(late)  # falls back too early: land earlier
    assert plan.duration[0] < TIME
    fixed = planner(time_weight=0.0, step={"time_change": 0.0}).plan(late)
    assert fixed.duration[0] == TIME
    assert plan.cost[0] < fixed.cost[0]
    narrow = planner(time_weight=0.0, step={"time_min": TIME}).plan(late)
    assert narrow.duration[0] >= TIME


@pytest.mark.parametrize(("left", "shortened"), [(0.07, True), (0.05, False)])
def test_no_step_is_shortened_in_its_last_moments(left, shortened):
    """Not to less than twice the lock: there has to be time for another plan."""
    late = TIME + STEP.time_change  # the nominal duration is cheaper
    now = replace(on_orbit(planner(), [[0.8, 0.0]], TIME - left), duration=np.array([late]))
    duration = planner(time_weight=1e3, lock=0.03).plan(now).duration[0]
    assert duration == pytest.approx(TIME if shortened else late)


def test_steps_for_several_times_are_those_for_each():
    """To the bit, also where bounds are active."""
    rng, case, ones = np.random.default_rng(3), planner(), np.ones(4)
    position, velocity = rng.normal(0, 0.15, (4, 2)), rng.normal(0, 0.8, (4, 2))
    now = Pendulum(position, velocity, -ones, 0.1 * ones, TIME * ones, np.zeros((4, 2)))
    times = np.array([[0.1], [0.2], [0.3]]) * ones
    lengths, cost = case.solve(now, times)
    for row, time in enumerate(times):
        for found, expected in zip((lengths[row], cost[row]), case.solve(now, time), strict=True):
            np.testing.assert_array_equal(found, expected)
    assert np.ptp(cost, axis=0).min() > 0
    assert np.isin(np.abs(lengths[:, :, 0]), 0.9).any(), "the largest length"
