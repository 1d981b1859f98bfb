"""The return map of a gait in all 22 states, with and without foot placement.

For reports, and a check of ``slider.hzd.walk``: controllers need the zero dynamics alone, which are
derived here a second time, from all columns of the map's derivative.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from slider.hzd.feedback import Regulator, regulate
from slider.hzd.plans import StepPlan
from slider.hzd.poincare import differences
from slider.hzd.step import ClosedLoop
from slider.hzd.walk import (
    STATE,
    by_phase,
    directions,
    middle,
    observed,
    with_moves,
    zero_dynamics,
)


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
    return observed(loop, loop.step(plan.of(rows), z[:, :STATE], z[:, STATE:]))
