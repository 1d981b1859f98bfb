"""Bézier polynomials of the phase s in [0, 1] (virtual constraints)."""

from functools import cache
from math import comb

import numpy as np


def basis(degree: int, s: np.ndarray) -> np.ndarray:
    """Bernstein polynomials (len(s), degree + 1)."""
    ahead, behind = _powers(degree, s)
    return _bernstein(degree, ahead, behind)


def _powers(degree: int, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Powers 0 … ``degree`` of s and of 1 − s (len(s), degree + 1)."""
    i = np.arange(degree + 1)
    s = np.asarray(s, dtype=float)[:, None]
    return s**i, (1 - s) ** i


def _bernstein(degree: int, ahead: np.ndarray, behind: np.ndarray) -> np.ndarray:
    """Polynomials of powers of at least this degree."""
    return _binomial(degree) * ahead[:, : degree + 1] * behind[:, degree::-1]


@cache
def _binomial(degree: int) -> np.ndarray:
    return np.array([comb(degree, k) for k in range(degree + 1)], dtype=float)


def basis_derivative(degree: int, s: np.ndarray, order: int) -> np.ndarray:
    """Derivatives with respect to s of the Bernstein polynomials (len(s), degree + 1)."""
    return _raised(basis(degree - order, s), degree)


def basis_orders(degree: int, s: np.ndarray, orders: int) -> list[np.ndarray]:
    """``basis_derivative`` of the first ``orders`` orders, from 0."""
    powers = _powers(degree, s)
    return [_raised(_bernstein(degree - order, *powers), degree) for order in range(orders)]


def _raised(matrix: np.ndarray, degree: int) -> np.ndarray:
    """Derivatives of the polynomials of a degree, from those of a lower one that is their last."""
    for d in range(matrix.shape[1], degree + 1):
        matrix = matrix @ _difference(d)
    return matrix


@cache
def _difference(degree: int) -> np.ndarray:
    """Coefficients of the derivative from those of the polynomial (degree, degree + 1)."""
    return degree * (np.eye(degree, degree + 1, k=1) - np.eye(degree, degree + 1))


def evaluate(coefficients: np.ndarray, s: np.ndarray, order: int = 0) -> np.ndarray:
    """Polynomials or their derivatives (len(s), n) of coefficients (n, degree + 1)."""
    return basis_derivative(coefficients.shape[1] - 1, s, order) @ coefficients.T
