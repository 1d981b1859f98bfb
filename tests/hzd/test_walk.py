"""Return maps whose derivatives are known: a rimless wheel, linear maps of known rank."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from slider.hzd.walk import chain, differences, limit_cycles, multipliers, restrict

GRAVITY_OVER_LENGTH = 9.81
SPOKES, SLOPE = np.pi / 8, 0.08  # half the angle between spokes, inclination [rad]


def rimless_wheel(x, _):
    """Rates (n, 1) just after an impact to those after the next one, by integration."""
    return np.array([[_roll_over(rate)] for (rate,) in x])


def _roll_over(rate: float) -> float:
    def derivative(_, state):
        return [state[1], GRAVITY_OVER_LENGTH * np.sin(state[0])]

    def guard(_, state):
        return state[0] - (SLOPE + SPOKES)

    guard.terminal = True
    start = [SLOPE - SPOKES, rate]
    exact = {"rtol": 1e-12, "atol": 1e-12, "max_step": 0.02}
    found = solve_ivp(derivative, (0, 5), start, "DOP853", events=guard, **exact)
    return np.cos(2 * SPOKES) * found.y[1, -1]


def test_the_rimless_wheel_has_the_multiplier_of_the_textbook():
    """ω⁺² = cos² 2α (ω² + 4 (g/l) sin α sin γ); McGeer 1990, section 3."""
    start = np.array([[1.15]])
    _, slopes = differences(rimless_wheel, start, 1e-5)
    points, found = limit_cycles([rimless_wheel], start, slopes, 1e-10)
    share = np.cos(2 * SPOKES) ** 2
    gain = 4 * GRAVITY_OVER_LENGTH * np.sin(SPOKES) * np.sin(SLOPE)
    assert found.all()
    np.testing.assert_allclose(points[0, 0, 0] ** 2, share / (1 - share) * gain, rtol=1e-9)
    for size in (1e-4, 5e-5):
        _, slope = differences(rimless_wheel, points[0], size)
        np.testing.assert_allclose(slope, [[[share]]], rtol=1e-7)


def test_a_cycle_of_linear_maps_is_found_for_each_system():
    rng = np.random.default_rng(0)
    turns, shifts = rng.standard_normal((2, 4, 3, 3)), rng.standard_normal((2, 4, 3))

    def mapped(step):
        return lambda x, k: np.einsum("nij,nj->ni", turns[step][k], x) + shifts[step][k]

    maps = [mapped(0), mapped(1)]
    points, found = limit_cycles(maps, np.zeros((4, 3)), turns[1] @ turns[0], 1e-10)
    assert found.all()
    everyone = np.arange(4)
    np.testing.assert_allclose(maps[0](points[0], everyone), points[1], atol=1e-9)
    np.testing.assert_allclose(maps[1](points[1], everyone), points[0], atol=1e-9)
    slopes = [differences(f, p, 1e-3)[1] for f, p in zip(maps, points, strict=True)]
    np.testing.assert_allclose(chain(slopes), turns[1] @ turns[0], atol=1e-9)


def test_a_cycle_is_found_with_slopes_that_are_only_near():
    """Broyden's correction: with the slopes alone half of the error would stay at each round."""
    seen = []

    def mapped(x, _):
        seen.append(len(x))
        return 3.0 * x - 4.0 + 0.1 * (x - 2.0) ** 2

    points, found = limit_cycles([mapped], np.array([[2.5], [2.0]]), np.full((2, 1, 1), 5.0), 1e-12)
    assert found.all()
    np.testing.assert_allclose(points[0], 2.0, atol=1e-11)
    assert seen[0] == 2, "both starts"
    assert set(seen[1:]) == {1}, "the one that is there stays"
    assert len(seen) < 10
    nowhere = [lambda x, _: x + 1.0 + x**2]
    _, found = limit_cycles(nowhere, np.array([[0.5], [np.nan]]), np.full((2, 1, 1), 2.0), 1e-9)
    assert not found.any()


def test_derivatives_along_directions_are_products_with_them():
    rng = np.random.default_rng(3)
    slope, directions = rng.standard_normal((2, 5, 4)), rng.standard_normal((2, 4, 3))
    points = rng.standard_normal((2, 4))
    values, found = differences(
        lambda x, k: np.einsum("nij,nj->ni", slope[k], x), points, 1e-3, 50.0 * directions
    )
    np.testing.assert_allclose(values, np.einsum("nij,nj->ni", slope, points), rtol=1e-12)
    np.testing.assert_allclose(found, 50.0 * slope @ directions, rtol=1e-9)


@pytest.mark.parametrize("period", [1, 2])
def test_the_restriction_has_the_multipliers_that_are_not_zero(period):
    """Maps H F of rank 2 in five dimensions, and tangents that are not their image."""
    rng = np.random.default_rng(period)
    futures = rng.standard_normal((period, 2, 5))
    derivatives = rng.standard_normal((period, 5, 2)) @ futures
    tangents = rng.standard_normal((period, 5, 2))
    now = futures @ tangents
    found = restrict(now, np.roll(futures, -1, axis=0) @ derivatives @ tangents)
    np.testing.assert_allclose(
        np.sort(np.abs(np.linalg.eigvals(chain(found)))),
        np.sort(np.abs(multipliers(derivatives)[:2])),
        rtol=1e-9,
    )
    projection = np.linalg.solve(now, futures)
    state, onward = rng.standard_normal(5), np.roll(projection, -1, axis=0)
    for z, after, a, whole in zip(projection, onward, found, derivatives, strict=True):
        np.testing.assert_allclose(after @ (whole @ state), a @ (z @ state), rtol=1e-9)
