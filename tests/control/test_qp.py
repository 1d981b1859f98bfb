"""The solver's answers are those of DAQP's own interface."""

import daqp
import numpy as np

from slider.control import qp


def programmes(count: int):
    """With bounds on three of six variables and limits of four rows."""
    rng = np.random.default_rng(0)
    root = rng.normal(size=(count, 6, 6))
    hessian = root @ root.swapaxes(1, 2) + 0.1 * np.eye(6)
    width = rng.uniform(0.1, 0.5, (count, 7))
    gradient = 5 * rng.normal(size=(count, 6))
    return hessian, gradient, rng.normal(size=(count, 4, 6)), -width, width


def test_infeasible_programme_has_no_solution():
    """Of the second of three."""
    lower, upper = np.tile([1.0, -qp.UNBOUNDED], (3, 1)), np.tile([2.0, 1.5], (3, 1))
    upper[1, 1] = 0.0
    x, solved = qp.solve(np.ones((3, 1, 1)), np.zeros((3, 1)), np.ones((3, 1, 1)), lower, upper)
    np.testing.assert_array_equal(solved, [True, False, True])
    np.testing.assert_allclose(x[:, 0], [1.0, 0.0, 1.0], atol=1e-9)


def test_solutions_are_those_of_the_python_interface():
    """To the bit: fails where another version of DAQP has other structures."""
    parts = programmes(30)
    x, solved = qp.solve(*parts)
    assert solved.all()
    for hessian, gradient, rows, lower, upper, minimiser in zip(*parts, x, strict=True):
        expected, _, flag, _ = daqp.solve(hessian, gradient, rows, upper, lower)
        assert flag == 1
        np.testing.assert_array_equal(minimiser, expected)
        free = -np.linalg.solve(hessian, gradient)
        assert np.abs(minimiser - free).max() > 1e-3, "some constraint is active"


def test_what_it_fails_on_is_solved_again(monkeypatch):
    """Every second programme: in other units to the same minimiser."""
    parts, solve, calls = programmes(6), qp._solve, []
    expected, _ = qp.solve(*parts)

    def fails_first(*given):
        x, flags = solve(*given)
        if not calls:
            x[::2], flags[::2] = np.nan, -1
        calls.append(len(x))
        return x, flags

    monkeypatch.setattr(qp, "_solve", fails_first)
    x, solved = qp.solve(*parts)
    assert solved.all()
    assert calls == [6, 3]
    np.testing.assert_allclose(x, expected, rtol=1e-9, atol=1e-10)


def test_a_minimiser_that_is_no_number_is_no_solution(monkeypatch):
    parts, solve = programmes(6), qp._solve

    def fails(*given):
        x, flags = solve(*given)
        x[1] = np.nan
        return x, flags

    monkeypatch.setattr(qp, "_solve", fails)
    x, solved = qp.solve(*parts)
    assert np.flatnonzero(~solved).tolist() == [1]
    assert not x[1].any()
