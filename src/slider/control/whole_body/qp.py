"""Convex quadratic programmes, solved by DAQP (dual active set).

DAQP because it is maintained, exact (active set, not first order), small enough for these sizes
and under the MIT licence. quadprog is as fast (23 against 26 µs on these QPs), but under the GPL.
Arnström, Bemporad and Axehill, "A dual active-set solver for embedded quadratic programming
using recursive LDLᵀ updates", IEEE TAC 2022.

It is called through its C interface (``api.h`` and ``types.h`` of DAQP 0.11): the Python one takes
as long for each QP as the solver itself.
"""

import ctypes

import daqp
import numpy as np

UNBOUNDED = 1e30  # DAQP's infinity
_SOLVED = 1

_PROBLEM = np.dtype(
    [(name, np.int32) for name in ("variables", "limits", "bounds")]
    + [(name, np.uintp) for name in ("hessian", "gradient", "rows", "upper", "lower")]
    + [(name, np.uintp) for name in ("sense", "breaks")]
    + [(name, np.int32) for name in ("levels", "kind")],
    align=True,
)
_RESULT = np.dtype(
    [(name, np.uintp) for name in ("x", "multipliers")]
    + [(name, float) for name in ("cost", "slack")]
    + [(name, np.int32) for name in ("flag", "iterations", "nodes")]
    + [(name, float) for name in ("solve_time", "setup_time")],
    align=True,
)
_DAQP = ctypes.PyDLL(daqp.__file__)  # PyDLL: to let other threads run between QPs costs more
_DAQP.daqp_default_settings.argtypes = [ctypes.c_void_p]
_DAQP.daqp_quadprog.argtypes = [ctypes.c_void_p] * 3
_DAQP.daqp_quadprog.restype = None
_SETTINGS = ctypes.create_string_buffer(256)  # 136 bytes, which DAQP fills
_DAQP.daqp_default_settings(_SETTINGS)


def solve(
    hessian: np.ndarray,
    gradient: np.ndarray,
    rows: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Minimise ½ xᵀ H x + gᵀ x with bounds on the first variables and on ``rows`` x, N times.

    Args:
        hessian: (N, n, n), positive definite.
        gradient: (N, n).
        rows: (N, m, n).
        lower, upper: (N, b + m); the first b bound the first b variables.

    Returns:
        x (N, n), zero where the constraints leave no solution, and where they leave one (N,).
    """
    count, size = gradient.shape
    limits = upper.shape[1]
    parts = {"hessian": hessian, "gradient": gradient, "rows": rows, "upper": upper, "lower": lower}
    parts = {name: np.ascontiguousarray(part, dtype=float) for name, part in parts.items()}
    x, multipliers = np.empty((count, size)), np.empty((count, limits))
    inequalities = np.zeros(limits, dtype=np.int32)
    problems, results = np.zeros(count, _PROBLEM), np.zeros(count, _RESULT)
    problems["variables"], problems["limits"] = size, limits
    problems["bounds"] = limits - rows.shape[1]
    problems["sense"] = inequalities.ctypes.data
    for name, part in parts.items():
        problems[name] = _addresses(part)
    results["x"], results["multipliers"] = _addresses(x), _addresses(multipliers)
    places = _addresses(results).tolist(), _addresses(problems).tolist()
    for result, problem in zip(*places, strict=True):
        _DAQP.daqp_quadprog(result, problem, _SETTINGS)
    solved = results["flag"] == _SOLVED
    x[~solved] = 0.0
    return x, solved


def _addresses(array: np.ndarray) -> np.ndarray:
    """Where the rows of an array are in memory (N,)."""
    return np.uintp(array.ctypes.data) + np.arange(len(array), dtype=np.uintp) * array.strides[0]
