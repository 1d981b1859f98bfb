"""Return maps: cycles of maps, their derivatives, and their restriction to a manifold.

A cycle of period k are maps P_0 … P_{k−1}, from section to section, and points
x_{j+1} = P_j(x_j), x_k = x_0. For a walk, a map is one step and a section the states just after
its impact. Maps take n points at once, (n, d) → (n, d).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

Map = Callable[[np.ndarray], np.ndarray]


def differences(function: Map, point: np.ndarray, size: float) -> np.ndarray:
    """Derivative (..., d) at a point (d,) of a function (n, d) → (n, ...), central differences."""
    steps = size * np.eye(len(point))
    values = function(np.concatenate([point + steps, point - steps]))
    above, below = np.split(values, 2)
    return np.moveaxis((above - below) / (2 * size), 0, -1)


def limit_cycle(
    maps: Sequence[Map], start: np.ndarray, size: float, tolerance: float, rounds: int = 12
) -> list[np.ndarray]:
    """Points (d,) of the cycle of ``maps`` near ``start``.

    Newton's method on x_0, the derivative taken once: (I − DP)(x − x_0) = P(x_0) − x_0.

    Raises:
        ValueError: none found.
    """
    point, inverse = start, None
    for _ in range(rounds):
        points = orbit(maps, point)
        missed = points[-1] - point
        if np.abs(missed).max() <= tolerance:
            return points[:-1]
        if inverse is None:
            inverse = np.linalg.inv(np.eye(len(point)) - total(maps, points, size))
        point = point + inverse @ missed
    raise ValueError(f"expected a limit cycle within {tolerance:g}, missed by {missed}")


def orbit(maps: Sequence[Map], start: np.ndarray) -> list[np.ndarray]:
    """The point and its images (d,) under one map after the other."""
    points = [start]
    for step in maps:
        points.append(step(points[-1][None])[0])
    return points


def total(maps: Sequence[Map], points: Sequence[np.ndarray], size: float) -> np.ndarray:
    """Derivative (d, d) of all maps in turn."""
    return chain([differences(step, p, size) for step, p in zip(maps, points, strict=False)])


def chain(derivatives: Sequence[np.ndarray]) -> np.ndarray:
    """Product of derivatives (d, d), the first map's to the right."""
    product = np.eye(derivatives[0].shape[1])
    for derivative in derivatives:
        product = derivative @ product
    return product


@dataclass(frozen=True)
class Restriction:
    """The r-dimensional dynamics on a manifold that attracts all points within one map.

    A perturbation off the manifold counts as the one on it that has the same future, ζ = Z x.

    Attributes:
        projection: Z (k, r, d).
        maps: A (k, r, r): ζ_{j+1} = A_j ζ_j; their product has the multipliers of the whole cycle
            that are not zero.
    """

    projection: np.ndarray
    maps: np.ndarray


def restrict(
    derivatives: Sequence[np.ndarray], tangents: Sequence[np.ndarray], futures: Sequence[np.ndarray]
) -> Restriction:
    """Restriction to a manifold.

    Args:
        derivatives: DP_j (d, d).
        tangents: E_j (d, r): x = E_j ξ on the manifold at section j.
        futures: F_j (r, d), derivative of what the rest of map j depends on alone.
    """
    projection = [np.linalg.solve(f @ e, f) for f, e in zip(futures, tangents, strict=True)]
    onward = projection[1:] + projection[:1]
    maps = [
        z @ derivative @ e
        for z, derivative, e in zip(onward, derivatives, tangents, strict=True)
    ]
    return Restriction(np.stack(projection), np.stack(maps))


def multipliers(derivatives: Sequence[np.ndarray]) -> np.ndarray:
    """Eigenvalues of the whole cycle (d,), greatest modulus first."""
    found = np.linalg.eigvals(chain(derivatives))
    return found[np.argsort(-np.abs(found))]
