"""Return maps: cycles of maps, their derivatives, and their restriction to a manifold.

A cycle of period k are maps P_0 … P_{k−1}, from section to section, and points
x_{j+1} = P_j(x_j), x_k = x_0. For a walk, a map is one step and a section the states just after
its impact. G systems are treated at once: a map takes points (n, d) and the system that each
belongs to (n,), and gives points (n, d).
"""

from collections.abc import Callable, Sequence

import numpy as np

Map = Callable[[np.ndarray, np.ndarray], np.ndarray]


def differences(
    function: Map, points: np.ndarray, size: float, directions: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """A function's values (G, m) at points (G, d) and its derivatives (G, m, k): central ones.

    They are along directions (G, d, k), by default the coordinates; all are moved by ``size``.
    """
    count, d = points.shape
    if directions is None:
        directions = np.broadcast_to(np.eye(d), (count, d, d))
    lengths = np.linalg.norm(directions, axis=1)[:, None]
    moves = size * (directions / lengths).transpose(0, 2, 1)
    starts = points[:, None] + np.concatenate([np.zeros((count, 1, d)), moves, -moves], axis=1)
    each = starts.shape[1]
    images = function(starts.reshape(-1, d), np.repeat(np.arange(count), each))
    values, ahead, behind = np.split(images.reshape(count, each, -1), [1, 1 + each // 2], axis=1)
    return values[:, 0], (ahead - behind).transpose(0, 2, 1) / (2 * size) * lengths


def limit_cycles(
    maps: Sequence[Map],
    start: np.ndarray,
    slopes: np.ndarray,
    tolerance: float,
    rounds: int = 20,
) -> tuple[np.ndarray, np.ndarray]:
    """Points (k, G, d) of the cycles of ``maps`` near ``start`` (G, d), and which converged (G,).

    Broyden's method on x_0: (I − DP)(x − x_0) = P(x_0) − x_0, DP corrected by what each step meets.
    ``slopes`` (G, d, d) are DP of the whole cycle at the start, in the directions that P leads to.
    """
    points = orbits(maps, start)
    residual = np.eye(start.shape[1]) - slopes
    for _ in range(rounds):
        missed = points[-1] - points[0]
        going = np.flatnonzero((np.abs(missed) > tolerance).any(axis=1))
        if not len(going):
            break
        ahead = np.linalg.solve(residual[going], missed[going, :, None])[..., 0]
        points[:, going] = orbits(maps, points[0, going] + ahead, going)
        left = (points[-1] - points[0])[going] / (ahead**2).sum(axis=1, keepdims=True)
        residual[going] -= left[:, :, None] * ahead[:, None]
    converged = (np.abs(points[-1] - points[0]) <= tolerance).all(axis=1)
    return points[:-1], np.asarray(converged)


def orbits(maps: Sequence[Map], start: np.ndarray, systems: np.ndarray | None = None) -> np.ndarray:
    """Points (k + 1, n, d): starts of some systems, by default of all, and their images in turn."""
    systems = np.arange(len(start)) if systems is None else systems
    points = [start]
    for step in maps:
        points.append(step(points[-1], systems))
    return np.stack(points)


def chain(derivatives: Sequence[np.ndarray] | np.ndarray) -> np.ndarray:
    """Product of derivatives (..., d, d), the first map's to the right."""
    product = derivatives[0]
    for derivative in derivatives[1:]:
        product = derivative @ product
    return product


def multipliers(derivatives: Sequence[np.ndarray] | np.ndarray) -> np.ndarray:
    """Eigenvalues of a whole cycle (d,), greatest modulus first."""
    eigenvalues = np.linalg.eigvals(chain(derivatives))
    return eigenvalues[np.argsort(-np.abs(eigenvalues))]


def restrict(now: np.ndarray, onward: np.ndarray) -> np.ndarray:
    """Derivatives (k, ..., r, m) of a cycle's maps on a manifold that attracts within one map.

    What the rest of a map depends on alone are r numbers; F_j are their derivatives at section j.
    A perturbation off the manifold counts as the one on it that has the same future.

    Args:
        now: F_j E_j (k, ..., r, r), with tangents x = E_j ξ of the manifold at the sections.
        onward: of F at the next section, along m directions at this one (k, ..., r, m). Along E_j
            they give A_j, ξ_{j+1} = A_j ξ_j, whose product has the multipliers of the whole cycle
            that are not zero.
    """
    return np.linalg.solve(np.roll(now, -1, axis=0), onward)
