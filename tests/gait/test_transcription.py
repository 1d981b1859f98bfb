"""Variables to nodes by Bézier polynomials, and the roll between them."""

import numpy as np
import pytest

from slider.gait import bezier
from slider.gait.solution import between_nodes

NODES = 9
S = np.linspace(0.0, 1.0, 11)


def test_a_straight_control_polygon_is_a_straight_line():
    coefficients = np.linspace(-1.0, 2.0, 7)[None]
    np.testing.assert_allclose(bezier.evaluate(coefficients, S)[:, 0], -1 + 3 * S, atol=1e-14)
    np.testing.assert_allclose(bezier.evaluate(coefficients, S, 1), 3.0, atol=1e-12)
    np.testing.assert_allclose(bezier.evaluate(coefficients, S, 2), 0.0, atol=1e-10)


@pytest.mark.parametrize("order", [1, 2])
def test_derivatives_by_central_differences(order):
    coefficients = np.random.default_rng(1).normal(size=(3, 7))
    s, h = S[1:-1], 1e-6
    up = bezier.evaluate(coefficients, s + h, order - 1)
    down = bezier.evaluate(coefficients, s - h, order - 1)
    expected = (up - down) / (2 * h)
    np.testing.assert_allclose(bezier.evaluate(coefficients, s, order), expected, atol=1e-6)
    assert np.abs(expected).max() > 1.0


def test_between_nodes_collocated_motion_is_a_cubic():
    coefficients = np.random.default_rng(2).normal(size=(1, 4))
    phases = np.linspace(0.0, 1.0, NODES), np.linspace(0.0, 1.0, 57)
    states, expected = (
        np.concatenate([bezier.evaluate(coefficients, phase, order) for order in range(3)], axis=1)
        for phase in phases
    )
    np.testing.assert_allclose(between_nodes(states, phases[1]), expected, atol=1e-10)
