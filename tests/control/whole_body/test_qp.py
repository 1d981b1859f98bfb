"""The solver's answers meet the optimality conditions."""

import numpy as np
import pytest

from slider.control.whole_body import qp


def conditions(hessian, gradient, rows, lower, upper, x) -> None:
    """Karush–Kuhn–Tucker: feasible, and −∇ is a non-negative combination of active normals."""
    bounds = len(lower) - len(rows)
    normals = np.vstack([np.eye(len(x))[:bounds], rows])
    values = normals @ x
    assert (values > lower - 1e-5).all()
    assert (values < upper + 1e-5).all()
    at_upper, at_lower = values > upper - 1e-5, values < lower + 1e-5
    active = np.vstack([normals[at_upper], -normals[at_lower]])
    slope = -(hessian @ x + gradient)
    if len(active) == 0:
        np.testing.assert_allclose(slope, 0, atol=1e-5)
        return
    multipliers = np.linalg.lstsq(active.T, slope, rcond=None)[0]
    np.testing.assert_allclose(active.T @ multipliers, slope, atol=1e-4)
    assert (multipliers > -1e-4).all()


@pytest.mark.parametrize("seed", range(8))
def test_optimality_conditions(seed):
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(6, 6))
    hessian, gradient = root @ root.T + 0.1 * np.eye(6), 5 * rng.normal(size=6)
    rows = rng.normal(size=(4, 6))
    width = rng.uniform(0.1, 0.5, 7)  # bounds on three variables, limits of four rows
    x = qp.solve(hessian, gradient, rows, -width, width)
    assert x is not None
    conditions(hessian, gradient, rows, -width, width, x)
    free = -np.linalg.solve(hessian, gradient)
    assert np.abs(x - free).max() > 1e-3, "some constraint is active"


def test_no_solution_is_said():
    lower, upper = np.array([1.0, -qp.UNBOUNDED]), np.array([2.0, 0.0])
    assert qp.solve(np.eye(1), np.zeros(1), np.ones((1, 1)), lower, upper) is None
