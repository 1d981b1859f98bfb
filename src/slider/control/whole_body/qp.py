"""Convex quadratic programmes, solved by DAQP (dual active set).

DAQP because it is maintained, exact (active set, not first order), small enough for these sizes
and under the MIT licence. quadprog is as fast (23 against 26 µs on these QPs), but under the GPL.
Arnström, Bemporad and Axehill, "A dual active-set solver for embedded quadratic programming
using recursive LDLᵀ updates", IEEE TAC 2022.
"""

# daqp has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

import daqp
import numpy as np

UNBOUNDED = 1e30  # DAQP's infinity
_SOLVED = 1


def solve(
    hessian: np.ndarray,
    gradient: np.ndarray,
    rows: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
) -> np.ndarray | None:
    """Minimise ½ xᵀ H x + gᵀ x with bounds on the first variables and on ``rows`` x.

    Args:
        hessian: (n, n), positive definite.
        gradient: (n,).
        rows: (m, n).
        lower, upper: (b + m,); the first b bound the first b variables.

    Returns:
        x (n,), or nothing where the constraints leave no solution.
    """
    x, _, flag, _ = daqp.solve(hessian, gradient, rows, upper, lower)
    return x if flag == _SOLVED else None
