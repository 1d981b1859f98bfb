"""The limit cycle of a gait, and its zero dynamics from step to step.

A Poincaré section holds the states just after an impact, x = (q, q̇). Outputs are zero or vanish by
mid-step (re-anchoring), so that the return map has the rank of the zero dynamics at a section.
Their coordinates are the first r of ξ = (c_y, ċ_y, ċ_x, c_x), position and velocity of the centre
of mass in the frame of the stance sole: r = 3 where the phase is the hip's position, 4 with the
clock. Per step ξ⁺ = A ξ + B b, b the displacement of the swing foot. States with equal ξ at
mid-step have the same future, so that r + 2 directions suffice: those of the zero dynamics and b,
followed from a section to the middle of the next step.

A cycle of period k consists of maps P_0 … P_{k−1} from section to section, and of points
x_{j+1} = P_j(x_j), x_k = x_0; for a walk a map is one step. G systems are treated at once: a map
takes points (G, d) and the index of each point's system (G,), and returns points (G, d).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.linalg import block_diag, null_space

from slider.core.arrays import take
from slider.gait.outputs import ANKLE
from slider.gait.rooted import NUM
from slider.hzd.model import Kinematics
from slider.hzd.plans import StepPlan, motion, start
from slider.hzd.step import PHASES, ClosedLoop, Flow

Map = Callable[[np.ndarray, np.ndarray], np.ndarray]
COORDINATES = ("com_y", "com_y_rate", "com_x_rate", "com_x")
STATE = 2 * NUM
_MOVES = 2  # directions of b
_DISPLACEMENTS = np.eye(STATE + _MOVES)[None, None, :, STATE:]


@dataclass(frozen=True)
class ZeroDynamics:
    """Two steps of n gaits that have the same kind of phase; S phases, r coordinates.

    Attributes:
        orbit: ξ* (2, n, S, 4) at ``PHASES``.
        maps, inputs: A (2, n, r, r), B (2, n, r, 2).
        by_state, by_input: ∂ξ(s)/∂ξ (2, n, S, r, r) and ∂ξ(s)/∂b (2, n, S, r, 2) at ``PHASES``.
        transition: ∂x/∂ξ (2, n, 22, r) of the states after the next impact.
    """

    orbit: np.ndarray
    maps: np.ndarray
    inputs: np.ndarray
    by_state: np.ndarray
    by_input: np.ndarray
    transition: np.ndarray


def find_cycles(loop: ClosedLoop, steps: Sequence[StepPlan]) -> tuple[np.ndarray, np.ndarray]:
    """Limit cycles of n gaits with one kind of phase: points (2, n, 22), and which converged (n,).

    Points are NaN where there is none. The return map is linearised along its image, that of the
    zero dynamics, and along the closure error of the walk from the collocated gait.
    """

    def transition(plan: StepPlan, x: np.ndarray, rows: np.ndarray) -> np.ndarray:
        return loop.step(take(plan, rows), x).after_impact.state

    maps = [partial(transition, plan) for plan in steps]
    first, *points = orbits(maps, start(steps[0], loop.config))
    missed = points[-1] - first
    others = np.broadcast_to(with_moves(missed)[:, :, None], (2, len(first), STATE + _MOVES, 1))
    around = linearise(loop, steps, np.stack([first, points[0]]), others)
    image = around.transition[1]
    before = np.concatenate([image, missed[:, :, None]], axis=2)
    after = np.concatenate([around.maps[0] @ around.maps[1], around.inputs[0]], axis=2)
    inverse = np.linalg.solve(before.mT @ before, before.mT)
    tolerance = loop.config.linearisation.tolerance
    points, converged = limit_cycles(maps, first, image @ after @ inverse, tolerance)
    return np.where(converged[:, None], points, np.nan), converged


def linearise(
    loop: ClosedLoop,
    steps: Sequence[StepPlan],
    points: np.ndarray,
    others: np.ndarray = _DISPLACEMENTS,
) -> ZeroDynamics:
    """Zero dynamics about walks through points (2, n, 22), by central differences.

    ``others`` (2, n, 24, k) are directions of states and displacements in addition to those of the
    zero dynamics: B has a column for each.
    """
    along = directions(loop, steps, others)
    size = loop.config.linearisation.difference
    derivatives = [
        differences(partial(_observe, loop, plan, after), with_moves(x), size, each)
        for plan, after, x, each in zip(steps, steps[::-1], points, along, strict=True)
    ]
    values, slopes = (np.stack(each) for each in zip(*derivatives, strict=True))
    parts = [STATE, slopes.shape[2] - len(COORDINATES)]
    transition, sampled, ahead = np.split(slopes, parts, axis=2)
    orbit = by_phase(values[:, :, STATE : -len(COORDINATES), None])[..., 0]
    r = along.shape[-1] - others.shape[-1]
    sampled, ahead = by_phase(sampled)[..., :r, :], ahead[..., :r, :]
    by_coordinate = np.linalg.inv(sampled[:, :, 0, :, :r])
    by_state = sampled[..., :r] @ by_coordinate[:, :, None]
    ahead = np.concatenate([ahead[..., :r] @ by_coordinate, ahead[..., r:]], axis=-1)
    maps, inputs = np.split(restrict(by_state[:, :, middle(loop)], ahead), [r], axis=-1)
    transition = transition[..., :r] @ by_coordinate
    return ZeroDynamics(orbit, maps, inputs, by_state, sampled[..., r:], transition)


def directions(
    loop: ClosedLoop, steps: Sequence[StepPlan], others: np.ndarray = _DISPLACEMENTS
) -> np.ndarray:
    """Directions of the zero dynamics at the sections, and others (2, n, 24, r + k).

    Positions and rates vary in the null space of the outputs; without a clock the phase's rate is
    one more direction, along the gait.
    """
    clock = steps[0].clock.all()  # the dimension of the zero dynamics depends on the phase
    r = len(COORDINATES) if clock else len(COORDINATES) - 1
    outputs = np.delete(loop.columns, ANKLE, axis=0) if clock else loop.columns
    free = np.asarray(block_diag(*2 * [null_space(outputs)]))
    at = np.zeros(len(steps[0].clock))
    result = np.zeros((2, len(at), STATE + _MOVES, r + others.shape[-1]))
    result[:, :, NUM:STATE, r - 1] = [motion(plan, at, loop.config)[1] for plan in steps]
    result[:, :, :STATE, : free.shape[1]] = free
    result[..., r:] = others
    return result


def middle(loop: ClosedLoop) -> int:
    """Index in ``PHASES`` from which the re-anchoring is over."""
    return int(np.searchsorted(PHASES, loop.config.correction_end - 1e-9))


def with_moves(x: np.ndarray) -> np.ndarray:
    """States (..., 22) followed by zero displacements (..., 24)."""
    return np.concatenate([x, np.zeros((*x.shape[:-1], _MOVES))], axis=-1)


def _observe(
    loop: ClosedLoop, plan: StepPlan, after: StepPlan, z: np.ndarray, rows: np.ndarray
) -> np.ndarray:
    """``observed``, then ξ at the middle of the next step, from states and displacements."""
    flow = loop.step(take(plan, rows), z[:, :STATE], z[:, STATE:])
    ahead = loop.part(take(after, rows), flow.after_impact.state, middle(loop))
    return np.concatenate([observed(loop, flow), _coordinates(loop.model.measure(*ahead))], axis=1)


def observed(loop: ClosedLoop, flow: Flow) -> np.ndarray:
    """States after the next impact (22), then ξ at all phases."""
    sampled = [_coordinates(loop.model.measure(q, v)) for q, v in zip(flow.q, flow.v, strict=True)]
    return np.concatenate([flow.after_impact.state, *sampled], axis=1)


def _coordinates(at: Kinematics) -> np.ndarray:
    return np.stack([at.com[:, 1], at.com_rate[:, 1], at.com_rate[:, 0], at.com[:, 0]], axis=1)


def by_phase(sampled: np.ndarray) -> np.ndarray:
    """Values (2, n, 4 S, m) as (2, n, S, 4, m)."""
    return sampled.reshape(*sampled.shape[:2], len(PHASES), len(COORDINATES), -1)


def differences(
    function: Map, points: np.ndarray, size: float, directions: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Evaluate a function (G, m) at points (G, d), and its central differences (G, m, k).

    The differences are along directions (G, d, k), by default the coordinates, of length ``size``.
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

    Broyden's method on x_0: (I − DP)(x − x_0) = P(x_0) − x_0, DP corrected by each step's residual.
    ``slopes`` (G, d, d) are DP of the entire cycle at the start, on the image of P.
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
    """Floquet multipliers of a cycle (d,), greatest modulus first."""
    eigenvalues = np.linalg.eigvals(chain(derivatives))
    return eigenvalues[np.argsort(-np.abs(eigenvalues))]


def restrict(now: np.ndarray, ahead: np.ndarray) -> np.ndarray:
    """Derivatives (k, ..., r, m) of a cycle's maps on a manifold that attracts within one map.

    The future of a point depends on r quantities only; F_j are their derivatives at section j. A
    perturbation off the manifold is replaced by the one on it that has the same future.

    Args:
        now: F_j E_j (k, ..., r, r), with tangents x = E_j ξ of the manifold at the sections.
        ahead: F at the next section along m directions at this one (k, ..., r, m). Along E_j the
            result is A_j, ξ_{j+1} = A_j ξ_j; the product of all A_j has the nonzero multipliers of
            the cycle.
    """
    return np.linalg.solve(np.roll(now, -1, axis=0), ahead)
