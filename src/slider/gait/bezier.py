"""Bézier polynomials of the phase s in [0, 1] (virtual constraints)."""

from functools import cache
from math import comb

import numpy as np


def basis(degree: int, s: np.ndarray) -> np.ndarray:
    """Bernstein polynomials (len(s), degree + 1)."""
    i = np.arange(degree + 1)
    s = np.asarray(s, dtype=float)[:, None]
    return _binomial(degree) * s**i * (1 - s) ** (degree - i)


@cache
def _binomial(degree: int) -> np.ndarray:
    return np.array([comb(degree, k) for k in range(degree + 1)], dtype=float)


def basis_derivative(degree: int, s: np.ndarray, order: int) -> np.ndarray:
    """Derivatives with respect to s of the Bernstein polynomials (len(s), degree + 1)."""
    matrix = basis(degree - order, s)
    for d in range(degree - order + 1, degree + 1):
        matrix = matrix @ _difference(d)
    return matrix


@cache
def _difference(degree: int) -> np.ndarray:
    """Coefficients of the derivative from those of the polynomial (degree, degree + 1)."""
    return degree * (np.eye(degree, degree + 1, k=1) - np.eye(degree, degree + 1))


def evaluate(coefficients: np.ndarray, s: np.ndarray, order: int = 0) -> np.ndarray:
    """Polynomials or their derivatives (len(s), n) of coefficients (n, degree + 1)."""
    return basis_derivative(coefficients.shape[1] - 1, s, order) @ coefficients.T
