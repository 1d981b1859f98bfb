"""Bézier polynomials of the phase s in [0, 1] (virtual constraints)."""

from functools import cache
from math import comb

import numpy as np


def basis_orders(degree: int, s: np.ndarray, orders: int) -> list[np.ndarray]:
    """Bernstein polynomials and their derivatives with respect to s, each (len(s), degree + 1)."""
    s, exponents = np.asarray(s, dtype=float)[:, None], np.arange(degree + 1)
    ahead, behind = s**exponents, (1 - s) ** exponents
    matrices = []
    for low in range(degree, degree - orders, -1):  # a derivative has a lower degree
        matrix = _binomial(low) * ahead[:, : low + 1] * behind[:, low::-1]
        for d in range(low + 1, degree + 1):
            matrix = matrix @ _difference(d)
        matrices.append(matrix)
    return matrices


def evaluate(coefficients: np.ndarray, s: np.ndarray, order: int = 0) -> np.ndarray:
    """Polynomials with coefficients (n, degree + 1), or a derivative of them, at s (len(s), n)."""
    return basis_orders(coefficients.shape[1] - 1, s, order + 1)[order] @ coefficients.T


@cache
def _binomial(degree: int) -> np.ndarray:
    return np.array([comb(degree, k) for k in range(degree + 1)], dtype=float)


@cache
def _difference(degree: int) -> np.ndarray:
    """Matrix (degree, degree + 1) from a polynomial's coefficients to its derivative's."""
    return degree * (np.eye(degree, degree + 1, k=1) - np.eye(degree, degree + 1))
