"""Hybrid invariance of the virtual constraints, measured.

The zero dynamics are hybrid invariant if an impact leaves the outputs and their rates at zero. The
constraints of a gait are, on its limit cycle alone: a roll that is not the cycle's leaves
(y, ẏ) ≠ 0. Re-anchored constraints start there, so that (y, ẏ) = 0 after any impact.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import null_space

from slider.config.hzd import ImpactGrid
from slider.gait.outputs import YAW, output_matrix
from slider.hzd.plans import StepPlan
from slider.hzd.step import ClosedLoop, Flow


@dataclass(frozen=True)
class Invariance:
    """Worst ‖(y, ẏ)‖∞ [rad, m, 1/s] of n gaits (n,), over both steps.

    Attributes:
        orbit: on the limit cycle, over a step.
        impact: just after perturbed impacts, of the constraints without re-anchoring.
        free, anchored: at the end of the step after them, without and with it.
        settle: pitch by which the ankle lays a foot flat that lands at another time [rad].
    """

    orbit: np.ndarray
    impact: np.ndarray
    free: np.ndarray
    anchored: np.ndarray
    settle: np.ndarray


def invariance(
    loop: ClosedLoop, steps: Sequence[StepPlan], points: np.ndarray, grid: ImpactGrid
) -> Invariance:
    """Of gaits with limit cycles through ``points`` (2, n, 22).

    States on the zero dynamics with another roll and roll rate walk one step; its impact is the
    perturbed one.
    """
    shape = points.shape[1], len(grid.roll) * len(grid.roll_rate)
    found = []
    for plan, after, point in zip(steps, steps[::-1], points, strict=True):
        rows, x = perturbed(loop, point, grid)
        impact = loop.step(plan.of(rows), x).landed
        landed = impact.state
        following = after.of(rows)
        free = loop.step(following, landed, anchored=False)
        anchored = loop.step(following, landed)
        cycle = loop.step(plan, point)
        worst = [free.residuals[0], _end(free), _end(anchored), np.abs(impact.pitch)]
        found.append([cycle.residuals.max(axis=0), *(w.reshape(shape).max(axis=1) for w in worst)])
    return Invariance(*np.array(found).max(axis=0))


def _end(flow: Flow) -> np.ndarray:
    return np.where(flow.alive, flow.residuals[-1], np.nan)


def perturbed(
    loop: ClosedLoop, points: np.ndarray, grid: ImpactGrid
) -> tuple[np.ndarray, np.ndarray]:
    """States with every roll and roll rate of a grid added to n states (n, 22).

    Joints move so that the outputs stay what they are.

    Returns:
        The state that each comes from (m,), and the states (m, 22), m = n · grid.
    """
    free = null_space(np.delete(output_matrix(loop.config.outputs), YAW, axis=1))[:, 0]
    turn = free / free[0]
    roll, rate = (each.ravel() for each in np.meshgrid(grid.roll, grid.roll_rate, indexing="ij"))
    offsets = np.concatenate([roll[:, None] * turn, rate[:, None] * turn], axis=1)
    rows = np.repeat(np.arange(len(points)), len(offsets))
    return rows, points[rows] + np.tile(offsets, (len(points), 1))
