"""CasADi functions of many states at once, as NumPy has them."""

from collections.abc import Sequence
from functools import cache

import casadi as ca
import numpy as np


class Batch:
    """A function of vectors that gives matrices, for n rows of arguments."""

    def __init__(self, arguments: Sequence[ca.SX], results: Sequence[ca.SX]) -> None:
        self._shapes = [result.shape for result in results]
        stacked = ca.vertcat(*(ca.vec(ca.densify(result)) for result in results))
        self._mapped = cache(ca.Function("batch", list(arguments), [stacked]).map)
        self._ends = np.cumsum([rows * columns for rows, columns in self._shapes])[:-1]

    def __call__(self, *arguments: np.ndarray) -> list[np.ndarray]:
        """Results (n, rows, columns), a single column as (n, rows), of arguments (n, width)."""
        n = len(arguments[0])
        found = self._mapped(n)(*(argument.T for argument in arguments)).full().T
        parts = np.split(found, self._ends, axis=1)
        return [
            part if columns == 1 else part.reshape(n, columns, rows).transpose(0, 2, 1)
            for part, (rows, columns) in zip(parts, self._shapes, strict=True)
        ]
