"""Quintics join their two states; rates are the derivatives of places."""

import numpy as np

from slider.control.whole_body.quintic import follow


def test_ends_and_derivatives():
    rng = np.random.default_rng(0)
    start, end = rng.normal(size=(4, 3)), rng.normal(size=(4, 3))
    duration = rng.uniform(0.2, 0.6, 4)
    np.testing.assert_allclose(follow(start, end, duration, 0.0), start, atol=1e-12)
    np.testing.assert_allclose(follow(start, end, duration, duration), end, atol=1e-9)
    eps, time = 1e-6, 0.13
    before, after = (follow(start, end, duration, time + s * eps) for s in (-1, 1))
    slope = (after - before)[:, :2] / (2 * eps)
    np.testing.assert_allclose(slope, follow(start, end, duration, time)[:, 1:], rtol=1e-5)


def test_replanning_from_the_curve_itself_changes_nothing():
    start, end = np.array([[0.0, 0.1, -1.0]]), np.array([[0.3, 0.0, 0.0]])
    whole = follow(start, end, np.array([0.4]), 0.25)
    middle = follow(start, end, np.array([0.4]), 0.1)
    np.testing.assert_allclose(follow(middle, end, np.array([0.3]), 0.15), whole, rtol=1e-9)
