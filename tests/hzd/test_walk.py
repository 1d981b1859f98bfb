"""Cycles and derivatives that are known: linear maps, and parabolas."""

import numpy as np

from slider.hzd.walk import chain, differences, limit_cycles


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
    """Central differences are exact for a map of second order."""
    rng = np.random.default_rng(3)
    slope, directions = rng.standard_normal((2, 5, 4)), rng.standard_normal((2, 4, 3))
    points = rng.standard_normal((2, 4))

    def mapped(x, k):
        return np.einsum("nij,nj->ni", slope[k], x) + (x**2).sum(axis=1, keepdims=True)

    values, found = differences(mapped, points, 1e-3, 50.0 * directions)
    np.testing.assert_allclose(values, mapped(points, np.arange(2)), rtol=1e-12)
    expected = 50.0 * (slope + 2 * points[:, None]) @ directions
    np.testing.assert_allclose(found, expected, rtol=1e-9)
