"""Perturbed walks about a limit cycle: hybrid invariance, basin of attraction, portraits.

The zero dynamics are hybrid invariant if an impact leaves the outputs and their rates at zero. The
constraints of a gait are, on its limit cycle alone: a roll that is not the cycle's leaves
(y, ẏ) ≠ 0. Re-anchored constraints start there, so that (y, ẏ) = 0 after any impact.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import null_space

from slider.config.hzd import BasinConfig, ImpactGrid
from slider.gait.outputs import YAW, output_matrix
from slider.gait.rooted import NUM
from slider.hzd.plans import StepPlan
from slider.hzd.return_map import ReturnMap
from slider.hzd.step import ClosedLoop, Flow

_PLANE = [0, NUM]  # roll and roll rate of a state
_FALLEN = 0.7  # a foot that has rolled so far [rad]


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
    """Measure hybrid invariance of gaits with limit cycles through ``points`` (2, n, 22).

    States on the zero dynamics with another roll and roll rate walk one step; its impact is the
    perturbed one.
    """
    shape = points.shape[1], len(grid.roll) * len(grid.roll_rate)
    worst = []
    for plan, after, point in zip(steps, steps[::-1], points, strict=True):
        rows, x = perturbed(loop, point, grid)
        impact = loop.step(plan.of(rows), x).landed
        landed = impact.state
        following = after.of(rows)
        free = loop.step(following, landed, anchored=False)
        anchored = loop.step(following, landed)
        cycle = loop.step(plan, point)
        perturbations = [free.residuals[0], _end(free), _end(anchored), np.abs(impact.pitch)]
        greatest = [each.reshape(shape).max(axis=1) for each in perturbations]
        worst.append([cycle.residuals.max(axis=0), *greatest])
    return Invariance(*np.array(worst).max(axis=0))


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


@dataclass(frozen=True)
class Placement:
    """Event-based foot placement b = −K Z (x − x*), bounded.

    Attributes:
        walk: with gains K and limit cycle x*.
        reach: greatest displacement in each direction [m].
    """

    walk: ReturnMap
    reach: float

    def displacement(self, step: int, x: np.ndarray) -> np.ndarray:
        """b (n, 2) [m] of states (n, 22) at the start of a step."""
        error = (x - self.walk.points[step]) @ self.walk.projection[step].T
        displacement = -error @ self.walk.regulator.gains[step].T
        return np.clip(displacement, -self.reach, self.reach)


def steps_until_return(
    loop: ClosedLoop,
    steps: Sequence[StepPlan],
    walk: ReturnMap,
    config: BasinConfig,
    placement: Placement | None,
) -> np.ndarray:
    """Steps (R, Q) after which a walk is back, for perturbed rolls and roll rates; else −1.

    It is back where roll and roll rate just after an impact are within ``config.returned`` of the
    limit cycle's.
    """
    grid = axes(config)
    _, x = perturbed(loop, walk.points[:1], grid)
    taken = np.full(len(x), -1)
    going = np.arange(len(x))
    for count in range(1, config.steps + 1):
        if not len(going):
            break
        step = (count - 1) % 2
        plan = steps[step].of(np.zeros(len(x), int))
        flow = loop.step(plan, x, _displaced(placement, step, x))
        x = flow.landed.state
        error = np.abs(x - walk.points[count % 2])[:, _PLANE]
        back = flow.alive & (error <= config.returned).all(axis=1)
        taken[going[back]] = count
        left = flow.alive & ~back & (np.abs(x[:, 0]) < _FALLEN)
        going, x = going[left], x[left]
    return taken.reshape(len(grid.roll), len(grid.roll_rate))


def _displaced(placement: Placement | None, step: int, x: np.ndarray) -> np.ndarray | None:
    return None if placement is None else placement.displacement(step, x)


def axes(config: BasinConfig) -> ImpactGrid:
    """Perturbations of a basin."""
    roll, rate = (
        np.linspace(each.lower, each.upper, config.points)
        for each in (config.roll, config.roll_rate)
    )
    return ImpactGrid(roll.tolist(), rate.tolist())


def portrait(
    loop: ClosedLoop,
    steps: Sequence[StepPlan],
    walk: ReturnMap,
    start: np.ndarray,
    count: int,
    placement: Placement | None,
) -> np.ndarray:
    """Roll and roll rate (steps · S, 2) of a walk from a state (22,), up to a fall."""
    x, seen = start[None], []
    for step in ([0, 1] * count)[:count]:
        flow = loop.step(steps[step], x, _displaced(placement, step, x))
        if not flow.alive[0]:
            break
        seen.append(np.stack([flow.q[:, 0, 0], flow.v[:, 0, 0]], axis=1))
        x = flow.landed.state
    return np.concatenate(seen) if seen else np.zeros((0, 2))
