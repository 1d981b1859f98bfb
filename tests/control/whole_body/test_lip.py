"""The pendulum in closed form against its integral; the orbits are fixed points."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from slider.control.whole_body import lip

OMEGA = lip.rate(0.65)


def test_rate_of_a_pendulum():
    assert lip.rate(9.81) == pytest.approx(1.0)
    assert lip.rate(0.65) == pytest.approx(3.8849, abs=1e-4)


@pytest.mark.parametrize("state", [(0.1, -0.3), (-0.12, 0.7)])
def test_step_map_is_the_integral_of_the_pendulum(state):
    found = lip.step_map(OMEGA, 0.37) @ state
    path = solve_ivp(lambda t, x: [x[1], OMEGA**2 * x[0]], (0, 0.37), state, rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(found, path.y[:, -1], rtol=1e-8)


def test_step_maps_are_stacked_and_compose():
    times = np.array([0.1, 0.25])
    maps = lip.step_map(OMEGA, times)
    assert maps.shape == (2, 2, 2)
    np.testing.assert_allclose(maps[0] @ maps[1], lip.step_map(OMEGA, 0.35), rtol=1e-12)


@pytest.mark.parametrize("time", [0.25, 0.4])
def test_forward_orbit_repeats_itself_with_the_mean_velocity(time):
    mean = np.array([0.8])
    end = lip.forward_end_velocity(OMEGA, time, mean)[0]
    length = 0.8 * time
    found = lip.step_map(OMEGA, time) @ [-length / 2, end]
    np.testing.assert_allclose(found, [length / 2, end], rtol=1e-12)  # then the foot moves by L
    assert end > 0.8


def test_lateral_orbit_comes_back_with_the_opposite_velocity():
    speed = lip.lateral_end_velocity(OMEGA, 0.4, 0.2)
    found = lip.step_map(OMEGA, 0.4) @ [-0.1, speed]
    np.testing.assert_allclose(found, [-0.1, -speed], rtol=1e-12)


def test_orbital_energy_is_conserved_and_negative_where_the_pendulum_turns_back():
    state = np.array([-0.1, lip.lateral_end_velocity(OMEGA, 0.4, 0.2)])
    later = lip.step_map(OMEGA, 0.3) @ state
    energy = lip.orbital_energy(OMEGA, state)
    assert lip.orbital_energy(OMEGA, later) == pytest.approx(energy, rel=1e-12)
    assert energy < 0
    assert lip.orbital_energy(OMEGA, np.array([-0.1, 0.5])) > 0
