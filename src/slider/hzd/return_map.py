"""For reports: return maps of gaits in all 22 states, and perturbed walks about limit cycles.

Controllers need the zero dynamics alone (``slider.hzd.walk``). These are derived here a second
time, as a check, from all columns of the map's derivative.

The zero dynamics are hybrid invariant if an impact leaves the outputs and their rates at zero. The
constraints of a gait are, on its limit cycle alone: a roll that is not the cycle's leaves
(y, ẏ) ≠ 0. Re-anchored constraints start there, so that (y, ẏ) = 0 after any impact.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.linalg import null_space

from slider.config.hzd import BasinConfig, ImpactGrid
from slider.core.arrays import take
from slider.gait.rooted import NUM
from slider.hzd.feedback import Regulator, regulate
from slider.hzd.plans import StepPlan
from slider.hzd.step import ClosedLoop
from slider.hzd.walk import (
    STATE,
    by_phase,
    differences,
    directions,
    middle,
    observed,
    with_moves,
    zero_dynamics,
)

_PLANE = [0, NUM]  # roll and roll rate of a state
_FALLEN = 0.7  # a foot that has rolled so far [rad]


@dataclass(frozen=True)
class ReturnMap:
    """Return map of a gait at its limit cycle, and its foot placement; r coordinates.

    Attributes:
        points: x* (2, 22) at the sections.
        derivatives: DP (2, 22, 22); ``placements``: ∂P/∂b (2, 22, 2).
        error: greatest change of these, and of ξ at all phases, with twice the difference.
        projection: Z (2, r, 22): ξ of the state on the zero dynamics with the same future.
        maps, inputs: A (2, r, r) and B (2, r, 2) of the zero dynamics.
        regulator: foot placement.
    """

    points: np.ndarray
    derivatives: np.ndarray
    placements: np.ndarray
    error: float
    projection: np.ndarray
    maps: np.ndarray
    inputs: np.ndarray
    regulator: Regulator

    @property
    def closed(self) -> np.ndarray:
        """A − B K (2, r, r)."""
        return self.maps - self.inputs @ self.regulator.gains

    def displacement(self, step: int, x: np.ndarray, reach: float) -> np.ndarray:
        """b = −K Z (x − x*) (n, 2) [m], bounded, of states (n, 22) at the start of a step."""
        error = (x - self.points[step]) @ self.projection[step].T
        return np.clip(-error @ self.regulator.gains[step].T, -reach, reach)

    @property
    def closed_derivatives(self) -> np.ndarray:
        """DP (2, 22, 22) with foot placement."""
        return self.derivatives - self.placements @ self.regulator.gains @ self.projection


def return_maps(loop: ClosedLoop, steps: Sequence[StepPlan], points: np.ndarray) -> list[ReturnMap]:
    """Return maps of n gaits with one kind of phase, limit cycles through points (2, n, 22).

    Raises:
        UserError: no foot placement stabilises one of them.
    """
    maps, at = [partial(_observe, loop, plan) for plan in steps], with_moves(points)
    size = loop.config.linearisation.difference
    (values, slopes), (_, coarse) = (
        (np.stack(part) for part in zip(*parts, strict=True))
        for parts in (
            [differences(each, z, share * size) for each, z in zip(maps, at, strict=True)]
            for share in (1.0, 2.0)
        )
    )
    along = directions(loop, steps)
    r = along.shape[-1] - slopes.shape[-1] + STATE
    landed, seen = slopes[:, :, :STATE], slopes[:, :, STATE:]
    future = by_phase(seen)[:, :, middle(loop), :, :STATE]
    moved = landed @ along
    zero = zero_dynamics(
        loop,
        r,
        by_phase(values[:, :, STATE:, None])[..., 0],
        moved,
        seen @ along,
        np.roll(future, -1, axis=0) @ moved,
    )
    derivatives, placements = landed[..., :STATE], landed[..., STATE:]
    errors = np.abs(slopes - coarse).max(axis=(0, 2, 3))
    projection = np.linalg.solve(zero.swung[:, :, middle(loop)], future[:, :, :r])
    return [
        ReturnMap(
            points[:, gait],
            derivatives[:, gait],
            placements[:, gait],
            float(errors[gait]),
            projection[:, gait],
            zero.maps[:, gait],
            zero.inputs[:, gait],
            regulate(zero, gait, loop.config.feedback),
        )
        for gait in range(points.shape[1])
    ]


def _observe(loop: ClosedLoop, plan: StepPlan, z: np.ndarray, rows: np.ndarray) -> np.ndarray:
    return observed(loop, loop.step(take(plan, rows), z[:, :STATE], z[:, STATE:]))


def invariance(
    loop: ClosedLoop, steps: Sequence[StepPlan], points: np.ndarray, grid: ImpactGrid
) -> dict[str, np.ndarray]:
    """Measure hybrid invariance of gaits with limit cycles through ``points`` (2, n, 22).

    States on the zero dynamics with another roll and roll rate walk one step; its impact is the
    perturbed one.

    Returns:
        Worst ‖(y, ẏ)‖∞ [rad, m, 1/s] (n,) over both steps: ``invariance_orbit`` over the limit
        cycle, ``invariance_impact`` just after perturbed impacts without re-anchoring,
        ``invariance_free`` and ``invariance_anchored`` at the end of the step after them without
        and with it; ``settle_angle`` by which the ankle lays a foot flat that lands at another
        time [rad].
    """
    shape = points.shape[1], len(grid.roll) * len(grid.roll_rate)
    worst = []
    for plan, after, point in zip(steps, steps[::-1], points, strict=True):
        rows, x = perturbed(loop, point, grid)
        impact = loop.step(take(plan, rows), x).landed
        following = take(after, rows)
        free = loop.step(following, impact.state, anchored=False)
        anchored = loop.step(following, impact.state)
        ends = (np.where(flow.alive, flow.residuals[-1], np.nan) for flow in (free, anchored))
        perturbations = [free.residuals[0], *ends, np.abs(impact.pitch)]
        greatest = [each.reshape(shape).max(axis=1) for each in perturbations]
        worst.append([loop.step(plan, point).residuals.max(axis=0), *greatest])
    names = [f"invariance_{name}" for name in ("orbit", "impact", "free", "anchored")]
    return dict(zip([*names, "settle_angle"], np.array(worst).max(axis=0), strict=True))


def perturbed(
    loop: ClosedLoop, points: np.ndarray, grid: ImpactGrid
) -> tuple[np.ndarray, np.ndarray]:
    """States with every roll and roll rate of a grid added to n states (n, 22).

    Joints move so that the outputs stay what they are.

    Returns:
        The state that each comes from (m,), and the states (m, 22), m = n · grid.
    """
    free = null_space(loop.columns)[:, 0]
    turn = free / free[0]
    roll, rate = (each.ravel() for each in np.meshgrid(grid.roll, grid.roll_rate, indexing="ij"))
    offsets = np.concatenate([roll[:, None] * turn, rate[:, None] * turn], axis=1)
    rows = np.repeat(np.arange(len(points)), len(offsets))
    return rows, points[rows] + np.tile(offsets, (len(points), 1))


def steps_until_return(
    loop: ClosedLoop,
    steps: Sequence[StepPlan],
    walk: ReturnMap,
    config: BasinConfig,
    reach: float,
) -> np.ndarray:
    """Steps (R, Q) after which a walk is back, for perturbed rolls and roll rates; else −1.

    It is back where roll and roll rate just after an impact are within ``config.returned`` of the
    limit cycle's. Feet are displaced by at most ``reach`` [m].
    """
    grid = axes(config)
    _, x = perturbed(loop, walk.points[:1], grid)
    taken = np.full(len(x), -1)
    going = np.arange(len(x))
    for count in range(1, config.steps + 1):
        if not len(going):
            break
        step = (count - 1) % 2
        plan = take(steps[step], np.zeros(len(x), int))
        flow = loop.step(plan, x, walk.displacement(step, x, reach))
        x = flow.landed.state
        error = np.abs(x - walk.points[count % 2])[:, _PLANE]
        back = flow.alive & (error <= config.returned).all(axis=1)
        taken[going[back]] = count
        left = flow.alive & ~back & (np.abs(x[:, 0]) < _FALLEN)
        going, x = going[left], x[left]
    return taken.reshape(len(grid.roll), len(grid.roll_rate))


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
    reach: float,
) -> np.ndarray:
    """Roll and roll rate (steps · S, 2) of a walk from a state (22,), up to a fall.

    Feet are displaced by at most ``reach`` [m].
    """
    x, seen = start[None], []
    for step in ([0, 1] * count)[:count]:
        flow = loop.step(steps[step], x, walk.displacement(step, x, reach))
        if not flow.alive[0]:
            break
        seen.append(np.stack([flow.q[:, 0, 0], flow.v[:, 0, 0]], axis=1))
        x = flow.landed.state
    return np.concatenate(seen) if seen else np.zeros((0, 2))
