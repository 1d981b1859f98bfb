"""Return maps: cycles of maps, their derivatives, and their restriction to a manifold.

A cycle of period k are maps P_0 … P_{k−1}, from section to section, and points
x_{j+1} = P_j(x_j), x_k = x_0. For a walk, a map is one step and a section the states just after
its impact. G systems are treated at once: a map takes points (n, d) and the system that each
belongs to (n,), and gives points (n, d).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

Map = Callable[[np.ndarray, np.ndarray], np.ndarray]


def differences(function: Map, points: np.ndarray, size: float) -> np.ndarray:
    """Derivatives (G, m, d) at points (G, d) of a function with values (n, m): central ones."""
    count, d = points.shape
    steps = size * np.concatenate([np.eye(d), -np.eye(d)])
    moved = (points[:, None] + steps).reshape(-1, d)
    values = function(moved, np.repeat(np.arange(count), 2 * d)).reshape(count, 2, d, -1)
    return (values[:, 0] - values[:, 1]).transpose(0, 2, 1) / (2 * size)


def limit_cycles(
    maps: Sequence[Map], start: np.ndarray, size: float, tolerance: float, rounds: int = 40
) -> tuple[np.ndarray, np.ndarray]:
    """Points (k, G, d) of the cycles of ``maps`` near ``start`` (G, d), and which were found (G,).

    Newton's method on x_0, the derivative taken once: (I − DP)(x − x_0) = P(x_0) − x_0.
    """
    x = start
    points = _orbits(maps, x)
    slopes = chain([differences(f, p, size) for f, p in zip(maps, points, strict=False)])
    for _ in range(rounds):
        missed = points[-1] - x
        if (np.abs(missed) <= tolerance).all():
            break
        x = x + np.linalg.solve(np.eye(x.shape[1]) - slopes, missed[..., None])[..., 0]
        points = _orbits(maps, x)
    found = (np.abs(points[-1] - x) <= tolerance).all(axis=1)
    return np.stack(points[:-1]), np.asarray(found)


def _orbits(maps: Sequence[Map], start: np.ndarray) -> list[np.ndarray]:
    """Points (G, d) and their images under one map after the other."""
    points, systems = [start], np.arange(len(start))
    for step in maps:
        points.append(step(points[-1], systems))
    return points


def chain(derivatives: Sequence[np.ndarray] | np.ndarray) -> np.ndarray:
    """Product of derivatives (..., d, d), the first map's to the right."""
    product = derivatives[0]
    for derivative in derivatives[1:]:
        product = derivative @ product
    return product


def multipliers(derivatives: Sequence[np.ndarray] | np.ndarray) -> np.ndarray:
    """Eigenvalues of a whole cycle (d,), greatest modulus first."""
    found = np.linalg.eigvals(chain(derivatives))
    return found[np.argsort(-np.abs(found))]


@dataclass(frozen=True)
class Restriction:
    """The r-dimensional dynamics on a manifold that attracts all points within one map.

    A perturbation off the manifold counts as the one on it that has the same future, ξ = Z x.

    Attributes:
        projection: Z (k, r, d).
        maps: A (k, r, r): ξ_{j+1} = A_j ξ_j; their product has the multipliers of the whole cycle
            that are not zero.
    """

    projection: np.ndarray
    maps: np.ndarray


def restrict(derivatives: np.ndarray, tangents: np.ndarray, futures: np.ndarray) -> Restriction:
    """Restriction of one system's maps to a manifold.

    Args:
        derivatives: DP (k, d, d).
        tangents: E (k, d, r): x = E ξ on the manifold at the sections.
        futures: F (k, r, d), derivatives of what the rest of a map depends on alone.
    """
    projection = np.linalg.solve(futures @ tangents, futures)
    return Restriction(projection, np.roll(projection, -1, axis=0) @ derivatives @ tangents)
