"""Derivatives of the assembled programme against central differences."""

import casadi as ca
import numpy as np
import pytest

from slider.gait.guess import STARTS, cold_start
from slider.gait.solve import Nlp
from tests.gait.gaits import config, problem

STEP_SIZE = 1e-6


def near_a_gait() -> np.ndarray:
    """A point with no symmetry, so that no derivative vanishes by accident."""
    rng = np.random.default_rng(3)
    x = cold_start(problem().layout, config().robot, 0.5, (0.25, 0.42), STARTS["cold"])
    return x + 0.05 * rng.normal(size=x.size)


def flat(value: ca.DM) -> np.ndarray:
    return value.full().ravel()


def assert_close(found: np.ndarray, expected: np.ndarray) -> None:
    scale = max(1.0, np.abs(expected).max())
    np.testing.assert_allclose(found / scale, expected / scale, atol=2e-7)


@pytest.mark.parametrize("turning", [False, True])
def test_gradient_jacobian_and_hessian_along_a_random_direction(turning):
    rng = np.random.default_rng(0)
    nlp = Nlp(problem(turning))
    x, velocity = near_a_gait(), np.array([0.5, -0.05, 0.3])
    direction = rng.normal(size=x.size)
    direction /= np.linalg.norm(direction)
    multipliers, factor = rng.normal(size=nlp.objective_and_rows.size1_out(1)), 0.4

    def along(function) -> np.ndarray:
        above, below = function(x + STEP_SIZE * direction), function(x - STEP_SIZE * direction)
        return (above - below) / (2 * STEP_SIZE)

    def lagrangian_gradient(z: np.ndarray) -> np.ndarray:
        slope = factor * flat(nlp.gradient(z, velocity)[1])
        return slope + flat(nlp.jacobian(z, velocity)[1].T @ ca.DM(multipliers))

    cost = along(lambda z: float(nlp.objective_and_rows(z, velocity)[0]))
    assert flat(nlp.gradient(x, velocity)[1]) @ direction == pytest.approx(cost, rel=1e-6, abs=1e-8)
    rows = along(lambda z: flat(nlp.objective_and_rows(z, velocity)[1]))
    assert_close(flat(nlp.jacobian(x, velocity)[1] @ ca.DM(direction)), rows)
    upper = nlp.hessian(x, velocity, factor, multipliers).full()
    hessian = upper + np.triu(upper, 1).T
    assert_close(hessian @ direction, along(lagrangian_gradient))
