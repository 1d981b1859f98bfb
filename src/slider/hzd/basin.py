"""Basin of attraction of a gait's limit cycle in (roll, roll rate), and walks towards it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slider.config.hzd import BasinConfig, ImpactGrid
from slider.gait.rooted import NUM
from slider.hzd.perturbed import perturbed
from slider.hzd.plans import StepPlan
from slider.hzd.return_map import Walk
from slider.hzd.step import ClosedLoop

_PLANE = [0, NUM]  # roll and roll rate of a state
_FALLEN = 0.7  # a foot that has rolled so far [rad]


@dataclass(frozen=True)
class Placement:
    """Event-based foot placement b = −K Z (x − x*), bounded.

    Attributes:
        walk: with gains K and limit cycle x*.
        reach: greatest displacement in each direction [m].
    """

    walk: Walk
    reach: float

    def displacement(self, step: int, x: np.ndarray) -> np.ndarray:
        """b (n, 2) [m] of states (n, 22) at the start of a step."""
        error = (x - self.walk.points[step]) @ self.walk.projection[step].T
        wanted = -error @ self.walk.regulator.gains[step].T
        return np.clip(wanted, -self.reach, self.reach)


def steps_until_return(
    loop: ClosedLoop,
    steps: Sequence[StepPlan],
    walk: Walk,
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
    walk: Walk,
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
