"""The pendulum against its integral and orbits; quintics join their two states."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from slider.control.whole_body import references
from slider.control.whole_body.references import quintic

OMEGA = references.natural_frequency(0.65)


@pytest.mark.parametrize("state", [(0.1, -0.3), (-0.12, 0.7)])
def test_step_map_is_the_integral_of_the_pendulum(state):
    found = references.step_map(OMEGA, 0.37) @ state
    path = solve_ivp(lambda t, x: [x[1], OMEGA**2 * x[0]], (0, 0.37), state, rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(found, path.y[:, -1], rtol=1e-8)


@pytest.mark.parametrize("time", [0.25, 0.4])
def test_forward_orbit_repeats_itself_with_the_mean_velocity(time):
    mean = np.array([0.8])
    end = references.forward_end_velocity(OMEGA, time, mean)[0]
    length = 0.8 * time
    found = references.step_map(OMEGA, time) @ [-length / 2, end]
    np.testing.assert_allclose(found, [length / 2, end], rtol=1e-12)  # then the foot moves by L
    assert end > 0.8


def test_lateral_orbit_comes_back_with_the_opposite_velocity():
    speed = references.lateral_end_velocity(OMEGA, 0.4, 0.2)
    found = references.step_map(OMEGA, 0.4) @ [-0.1, speed]
    np.testing.assert_allclose(found, [-0.1, -speed], rtol=1e-12)


def test_orbital_energy_is_conserved_and_negative_where_the_pendulum_turns_back():
    state = np.array([-0.1, references.lateral_end_velocity(OMEGA, 0.4, 0.2)])
    later = references.step_map(OMEGA, 0.3) @ state
    energy = references.orbital_energy(OMEGA, state)
    assert references.orbital_energy(OMEGA, later) == pytest.approx(energy, rel=1e-12)
    assert energy < 0
    assert references.orbital_energy(OMEGA, np.array([-0.1, 0.5])) > 0


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


def test_replanning_from_the_quintic_itself_changes_nothing():
    start, end = np.array([[0.0, 0.1, -1.0]]), np.array([[0.3, 0.0, 0.0]])
    whole = quintic(start, end, np.array([0.4]), 0.25)
    middle = quintic(start, end, np.array([0.4]), 0.1)
    np.testing.assert_allclose(quintic(middle, end, np.array([0.3]), 0.15), whole, rtol=1e-9)
