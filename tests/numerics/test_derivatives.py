"""Derivatives of every symbolic function against central differences."""

import casadi as ca
import numpy as np
import pytest

from slider.gait.guess import STARTS, cold_start
from slider.gait.solve import Nlp
from slider.gait.transcription import NODE
from tests.gait.gaits import config, problem, solver

STEP_SIZE = 1e-6
TURN = np.array([0.3, 0.2])  # yaw rate [rad/s] and phase of a node

both = pytest.mark.parametrize("turning", [False, True])


def near_a_gait() -> np.ndarray:
    """A point with no symmetry, so that no derivative vanishes by accident."""
    rng = np.random.default_rng(3)
    x = cold_start(problem().layout, config().robot, 0.5, (0.25, 0.42), STARTS["cold"])
    return x + 0.05 * rng.normal(size=x.size)


def differences(function, x: np.ndarray) -> np.ndarray:
    """Central differences (rows, len(x))."""
    columns = []
    for i in range(len(x)):
        step = np.zeros_like(x)
        step[i] = STEP_SIZE
        columns.append((function(x + step) - function(x - step)) / (2 * STEP_SIZE))
    return np.stack(columns, axis=-1)


def dense(value: ca.DM) -> np.ndarray:
    return np.array(ca.densify(value))


def flat(value: ca.DM) -> np.ndarray:
    return dense(value).ravel()


def assert_close(found: np.ndarray, expected: np.ndarray) -> None:
    scale = max(1.0, np.abs(expected).max())
    np.testing.assert_allclose(found / scale, expected / scale, atol=2e-7)


def node_vector() -> np.ndarray:
    return flat(problem().layout.select_nodes @ near_a_gait())[5 * NODE : 6 * NODE]


@both
def test_node_cost_rows_and_their_derivatives(turning):
    x, weight, factor = node_vector(), 0.03, 0.7
    functions = problem(turning).functions
    node = functions["node"]
    cost, value = node(x, weight, TURN)
    rows, jacobian = functions["node_jacobian"](x, TURN)
    np.testing.assert_allclose(flat(rows), flat(value), rtol=1e-12)
    assert_close(dense(jacobian), differences(lambda y: flat(node(y, weight, TURN)[1]), x))
    expected = differences(lambda y: float(node(y, weight, TURN)[0]), x)
    assert_close(flat(functions["cost"](x, weight)[1]), expected)
    assert float(cost) > 0
    multipliers = np.random.default_rng(0).normal(size=len(flat(rows)))

    def lagrangian_gradient(y: np.ndarray) -> np.ndarray:
        slope = factor * flat(functions["cost"](y, weight)[1])
        return slope + dense(functions["node_jacobian"](y, TURN)[1]).T @ multipliers

    hessian = dense(functions["node_hessian"](x, weight, TURN, factor, multipliers))
    assert_close(hessian, differences(lagrangian_gradient, x))


@pytest.mark.parametrize(
    ("name", "turning"), [("ends", False), ("ends", True), ("collocation", False)]
)
def test_impact_and_step_ends_and_collocation(name, turning):
    functions, x, velocity = problem(turning).functions, near_a_gait(), list[np.ndarray]()
    if name == "ends":
        x, velocity = flat(problem().layout.select_ends @ x), [np.array([0.5, 0.05, 0.3])]
    value, slope = functions[name], functions[f"{name}_jacobian"]
    jacobian = dense(slope(x, *velocity)[1])
    assert_close(jacobian, differences(lambda z: flat(value(z, *velocity)), x))
    multipliers = np.random.default_rng(1).normal(size=len(jacobian))
    expected = differences(lambda z: dense(slope(z, *velocity)[1]).T @ multipliers, x)
    assert_close(dense(functions[f"{name}_hessian"](x, *velocity, multipliers)), expected)


@both
@pytest.mark.parametrize("seed", [0, 1])
def test_assembled_programme_along_random_directions(seed, turning):
    rng = np.random.default_rng(seed)
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
    upper = dense(nlp.hessian(x, velocity, factor, multipliers))
    hessian = upper + np.triu(upper, 1).T
    assert_close(hessian @ direction, along(lagrangian_gradient))


def test_rows_and_bounds_belong_together():
    lower, upper = problem().row_bounds
    rows = np.concatenate([block.rows for block in problem().blocks])
    np.testing.assert_array_equal(np.sort(rows), np.arange(len(lower)))
    assert (lower <= upper).all()
    assert solver().problem.layout.size == len(problem().variable_bounds((0.25, 0.42))[0])
