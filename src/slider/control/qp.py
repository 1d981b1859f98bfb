"""Convex quadratic programmes, solved by DAQP (dual active set).

DAQP because it is maintained, exact (active set, not first order), small enough for these sizes
and under the MIT licence. quadprog is as fast (23 against 26 µs on these QPs), but under the GPL.
Arnström, Bemporad and Axehill, "A dual active-set solver for embedded quadratic programming
using recursive LDLᵀ updates", IEEE TAC 2022.

DAQP is called through its C interface (``api.h`` and ``types.h`` of 0.11) in a compiled loop. The
Python interface takes 3 µs more per QP: 11 to 15 % of a baseline's time. The structures are those
of 0.11 only, which ``pyproject.toml`` requires and a comparison of both interfaces tests.
"""

import ctypes

import daqp
import llvmlite.binding
import numpy as np
from numba import types

from slider.core.compiled import compiled

UNBOUNDED = 1e30  # DAQP's infinity
_SOLVED, _DID_NOT_RUN = 1, 0  # DAQP has no flag 0

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
_SETTINGS, _LENIENT = (ctypes.create_string_buffer(256) for _ in range(2))  # DAQP fills 136 bytes
for _settings in (_SETTINGS, _LENIENT):
    ctypes.CDLL(daqp.__file__).daqp_default_settings(_settings)
_zero_tol = ctypes.c_double.from_buffer(_LENIENT, 2 * ctypes.sizeof(ctypes.c_double))
_zero_tol.value = 1e-7  # instead of 1e-11
llvmlite.binding.load_library_permanently(daqp.__file__)
_quadprog = types.ExternalFunction("daqp_quadprog", types.void(*[types.uintp] * 3))


def solve(
    hessian: np.ndarray,
    gradient: np.ndarray,
    rows: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Minimise ½ xᵀ H x + gᵀ x with bounds on the first variables and on ``rows`` x, N times.

    On some feasible QPs of a heavy robot on two soles, DAQP fails: infeasible, initially
    overdetermined, cycling. Those are solved again with a larger tolerance, and scaled such that H
    has a unit diagonal.

    Args:
        hessian: (N, n, n), positive definite.
        gradient: (N, n).
        rows: (N, m, n).
        lower, upper: (N, b + m); the first b bound the first b variables.

    Returns:
        x (N, n), zero where no solution was found, and whether one was found (N,).

    Raises:
        RuntimeError: the solver did not run.
    """
    x, flags = _solve(hessian, gradient, rows, lower, upper, _SETTINGS)
    if len(again := np.flatnonzero(flags != _SOLVED)):
        hessian, rows = hessian[again], rows[again]
        unit = 1.0 / np.sqrt(np.einsum("nii->ni", hessian))
        across, bounds = unit[:, None], upper.shape[1] - rows.shape[1]
        bound = np.ones((len(again), upper.shape[1]))
        bound[:, :bounds] = unit[:, :bounds]
        scaled = across * hessian * unit[:, :, None], unit * gradient[again], across * rows
        limits = lower[again] / bound, upper[again] / bound
        y, flags[again] = _solve(*scaled, *limits, _LENIENT)
        x[again] = unit * y
    solved = (flags == _SOLVED) & np.isfinite(x).all(axis=1)
    x[~solved] = 0.0
    return x, solved


def _solve(
    hessian: np.ndarray,
    gradient: np.ndarray,
    rows: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    settings: ctypes.Array[ctypes.c_char],
) -> tuple[np.ndarray, np.ndarray]:
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
    _each(_addresses(results), _addresses(problems), np.uintp(ctypes.addressof(settings)))
    if (results["flag"] == _DID_NOT_RUN).any():
        raise RuntimeError("DAQP: expected a flag for each QP, found 0: the solver did not run")
    return x, results["flag"]


@compiled
def _each(results: np.ndarray, problems: np.ndarray, settings: np.uintp) -> None:
    for i in range(len(results)):
        _quadprog(results[i], problems[i], settings)


def _addresses(array: np.ndarray) -> np.ndarray:
    """Addresses of the rows of an array (N,)."""
    return np.uintp(array.ctypes.data) + np.arange(len(array), dtype=np.uintp) * array.strides[0]
