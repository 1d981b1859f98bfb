"""P by scipy, V by its definition, and its decrease along the closed loop of the LQR."""

import numpy as np
import pytest
from scipy.linalg import eigh, expm, solve_continuous_are

from slider.env.rewards import Lyapunov

CASES = [(20.0, 2.0), (1.0, 0.0), (7.3, 11.0)]
F, G = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0], [1.0]])


def weights(clf: Lyapunov) -> tuple[np.ndarray, np.ndarray]:
    """Q and R in seconds."""
    return np.diag([1.0, clf.rate_weight / clf.bandwidth**2]), np.array([[clf.bandwidth**-4.0]])


def in_seconds(clf: Lyapunov) -> np.ndarray:
    """P of (y, ẏ), whose V is the cost of the LQR [s]."""
    scale = np.diag([1.0, 1.0 / clf.bandwidth])
    return scale @ clf.matrix @ scale / clf.bandwidth


@pytest.mark.parametrize("case", CASES)
def test_p_solves_the_riccati_equation(case):
    clf = Lyapunov(*case)
    q, r = weights(clf)
    np.testing.assert_allclose(in_seconds(clf), solve_continuous_are(F, G, q, r), rtol=1e-9)


@pytest.mark.parametrize("case", CASES)
def test_many_outputs_are_blocks(case):
    """V of three outputs is that of the Riccati equation of all three together."""
    clf, three = Lyapunov(*case), np.eye(3)
    q, r = weights(clf)
    whole = solve_continuous_are(*(np.kron(three, block) for block in (F, G, q, r)))
    error = np.random.default_rng(0).standard_normal((5, 2, 3))
    eta = error.transpose(0, 2, 1).reshape(5, 6)
    expected = clf.bandwidth * np.einsum("ni,ij,nj->n", eta, whole, eta)
    np.testing.assert_allclose(clf.value(error), expected, rtol=1e-9)


@pytest.mark.parametrize("case", CASES)
def test_the_norm_of_p(case):
    clf = Lyapunov(*case)
    assert clf.largest == pytest.approx(np.linalg.eigvalsh(clf.matrix).max())
    assert clf.largest == pytest.approx(np.linalg.norm(clf.matrix, ord=2))


@pytest.mark.parametrize("case", CASES)
def test_v_decreases_along_the_closed_loop_of_the_lqr(case):
    """V̇ ≤ −λV with the greatest λ that Q and P allow, which some state attains."""
    clf = Lyapunov(*case)
    (q, r), p = weights(clf), in_seconds(clf)
    gain = np.linalg.solve(r, G.T @ p)
    decay = eigh(q + gain.T @ r @ gain, p, eigvals_only=True)[0]
    assert decay > 0.1 * clf.bandwidth
    poles = np.linalg.eigvals(F - G @ gain)
    np.testing.assert_allclose(np.prod(poles).real, clf.bandwidth**2)
    np.testing.assert_allclose(-poles.sum().real, clf.bandwidth * np.sqrt(clf.rate_weight + 2.0))
    period = 0.02 / clf.bandwidth
    step = expm((F - G @ gain) * period)
    eta = np.random.default_rng(1).standard_normal((400, 2)) * [1.0, clf.bandwidth]
    ratios = []
    for _ in range(100):
        after = eta @ step.T
        ratios.append(clf.value(after[:, :, None]) / clf.value(eta[:, :, None]))
        eta = after
    assert np.max(ratios) <= np.exp(-decay * period) * (1 + 1e-9)
    assert np.max(ratios) > np.exp(-1.01 * decay * period)
