"""CasADi functions of many states at once, as NumPy has them."""

from collections.abc import Sequence
from functools import cache

import casadi as ca
import numpy as np

from slider.core.casadi_code import Source, interpreted


class Batch:
    """A function of vectors that gives matrices, for n rows of arguments."""

    def __init__(
        self,
        arguments: Sequence[ca.SX],
        results: Sequence[ca.SX],
        functions: Source = interpreted,
    ) -> None:
        self._shapes = [result.shape for result in results]
        stacked = ca.vertcat(*(ca.vec(ca.densify(result)) for result in results))
        derived = ca.Function("batch", list(arguments), [ca.cse(stacked)])
        one = functions(derived.serialize(), lambda: {"batch": derived})["batch"]
        self._mapped = cache(lambda n: one.map(n).buffer())
        sizes = np.cumsum([rows * columns for rows, columns in self._shapes])
        self._ends, self._size = sizes[:-1], int(sizes[-1])

    def __call__(self, *arguments: np.ndarray) -> list[np.ndarray]:
        """Results (n, rows, columns), a single column as (n, rows), of arguments (n, width)."""
        n = len(arguments[0])
        found = np.empty((n, self._size))
        if n:
            self._evaluate(arguments, found)
        parts = np.split(np.asfortranarray(found), self._ends, axis=1)  # by columns: fast to use
        return [
            part if columns == 1 else part.reshape(n, columns, rows).transpose(0, 2, 1)
            for part, (rows, columns) in zip(parts, self._shapes, strict=True)
        ]

    def _evaluate(self, arguments: Sequence[np.ndarray], found: np.ndarray) -> None:
        buffer, evaluate = self._mapped(len(found))
        rows = [np.ascontiguousarray(argument, dtype=float) for argument in arguments]
        for place, values in enumerate(rows):  # rows in NumPy's order are CasADi's columns
            buffer.set_arg(place, values.data)  # pyright: ignore[reportCallIssue]
        buffer.set_res(0, found.data)  # pyright: ignore[reportCallIssue]
        evaluate()
