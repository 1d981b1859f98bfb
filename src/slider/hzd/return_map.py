"""The return map of a gait in all of its states, with and without foot placement.

Controllers need its zero dynamics alone; these are derived here a second time, from all 22
columns of the map's derivative.
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
    ZeroDynamics,
    by_phase,
    directions,
    middle,
    observed,
    with_moves,
    zero_dynamics,
)


@dataclass(frozen=True)
class ReturnMaps:
    """Return maps of n gaits at their limit cycles.

    Attributes:
        points: x* (2, n, 22) at the sections.
        derivatives: DP (2, n, 22, 22); ``placements``: ∂P/∂b (2, n, 22, 2).
        errors: greatest change of these, and of ξ at all phases, with twice the difference (n,).
        projection: Z (2, n, r, 22): ξ of the state on the zero dynamics with the same future.
        zero: the zero dynamics.
    """

    points: np.ndarray
    derivatives: np.ndarray
    placements: np.ndarray
    errors: np.ndarray
    projection: np.ndarray
    zero: ZeroDynamics


@dataclass(frozen=True)
class Walk:
    """One gait of ``ReturnMaps``, with its regulator."""

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


def return_maps(loop: ClosedLoop, steps: Sequence[StepPlan], points: np.ndarray) -> ReturnMaps:
    """Of n gaits with one kind of phase, limit cycles through points (2, n, 22)."""
    maps, at = [partial(_observe, loop, plan) for plan in steps], with_moves(points)
    size = loop.config.linearisation.difference
    (values, slopes), (_, coarse) = (
        (np.stack(part) for part in zip(*found, strict=True))
        for found in (
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
    return ReturnMaps(
        points,
        landed[..., :STATE],
        landed[..., STATE:],
        np.abs(slopes - coarse).max(axis=(0, 2, 3)),
        np.linalg.solve(zero.swung[:, :, middle(loop)], future[:, :, :r]),
        zero,
    )


def _observe(loop: ClosedLoop, plan: StepPlan, z: np.ndarray, rows: np.ndarray) -> np.ndarray:
    return observed(loop, loop.step(plan.of(rows), z[:, :STATE], z[:, STATE:]))


def walk(loop: ClosedLoop, found: ReturnMaps, gait: int) -> Walk:
    """One of the gaits with foot placement.

    Raises:
        UserError: no foot placement stabilises it.
    """
    return Walk(
        found.points[:, gait],
        found.derivatives[:, gait],
        found.placements[:, gait],
        float(found.errors[gait]),
        found.projection[:, gait],
        found.zero.maps[:, gait],
        found.zero.inputs[:, gait],
        regulate(found.zero, gait, loop.config.feedback),
    )
