"""Virtual constraints of a step of n robots: the gait's motion, re-anchored, with foot placement.

x_d(s) = X(s) + c(s) + D b(s) over the phase s in [0, 1]. X is the gait: Bézier polynomials of the
virtual leg through eq. 1, and the roll of the stance foot. c re-anchors the constraints after an
impact: it starts with the error that the impact left, in position and velocity, and is gone by
mid-step (Morris and Grizzle, "Hybrid invariant manifolds in systems with impulse effects with
application to periodic locomotion in bipedal robots", IEEE TAC 54(8), 2009). D moves the swing
foot level by b [m].
"""

from dataclasses import dataclass, field

import numpy as np

from slider.gait import bezier
from slider.gait.outputs import JOINTS, NUM_COORDINATES, ROLL, SWING
from slider.hzd.polynomials import (
    NodeTable,
    Orders,
    extended,
    fade_slope,
    fade_value,
    smooth_step,
)
from slider.robot.knee_map import KneeLengths, prismatic_motion

_SLIDE = SWING - JOINTS + 3  # of the swing leg, among the joints
_LEAST = 0.2  # a correction lasts at least this share of a step
_NEWTON = 4  # steps from the linear guess of a phase; the table is smooth


@dataclass
class StepConstraints:
    """Constraints of the steps that n robots are making, stance leg first.

    Attributes:
        coefficients: Bézier coefficients of the virtual legs (n, 10, degree + 1) [rad].
        roll: of the stance foot's line (m = 1) [rad] over the phase.
        placement: D (n, 10, 2), joints that move the swing foot forward and left [rad/m, m/m].
        lengths: of the virtual leg.
        correction_end: phase at which the re-anchoring is over.
        placement_span: phases between which the foot is displaced.
        anchor: (n,) phase at which the last impact left the errors.
        error, error_slope: (n, 12) of the coordinates then, and their derivative over the phase.
        displacement: b (n, 2) forward and left in the stance foot's reflected frame [m].
    """

    coefficients: np.ndarray
    roll: NodeTable
    placement: np.ndarray
    lengths: KneeLengths
    correction_end: float
    placement_span: tuple[float, float]
    anchor: np.ndarray = field(init=False)
    error: np.ndarray = field(init=False)
    error_slope: np.ndarray = field(init=False)
    displacement: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        n = len(self.coefficients)
        self.anchor = np.zeros(n)
        self.error, self.error_slope = np.zeros((2, n, NUM_COORDINATES))
        self.displacement = np.zeros((n, 2))

    def re_anchor(self, phase: np.ndarray, x: np.ndarray, slope: np.ndarray) -> None:
        """Start the steps at coordinates x (n, 12) and their derivative over the phase (n, 12)."""
        self.error[:] = self.error_slope[:] = 0.0
        desired, desired_slope, _ = self.desired(phase)
        self.anchor = phase.copy()
        self.error, self.error_slope = x - desired, slope - desired_slope

    def desired(self, phase: np.ndarray) -> Orders:
        """x_d (n, 12) and its first and second derivatives over the phase at phases (n,).

        Before the start and after the end of the step the motion goes on almost straight.
        """
        within = np.clip(phase, 0.0, 1.0)
        value, slope, curve = extended(self._gait(within), phase - within)
        for part, order in zip((value, slope, curve), self._correction(phase), strict=True):
            part += order
        for part, order in zip((value, slope, curve), self._displaced(phase), strict=True):
            part[:, JOINTS:] += order
        return value, slope, curve

    def _gait(self, phase: np.ndarray) -> Orders:
        basis = bezier.basis_orders(self.coefficients.shape[2] - 1, phase, 3)
        q, v, a = (np.einsum("nk,njk->nj", each, self.coefficients) for each in basis)
        legs, rolls = prismatic_motion(q, v, a, self.lengths), self.roll.at(phase)
        orders = np.zeros((3, len(phase), NUM_COORDINATES))
        for order in range(3):
            orders[order, :, ROLL] = rolls[order][:, 0]
            orders[order, :, JOINTS:] = legs[order]
        return orders[0], orders[1], orders[2]

    def _correction(self, phase: np.ndarray) -> Orders:
        span = np.maximum(self.correction_end - self.anchor, _LEAST)
        u, span = (phase - self.anchor) / span, span[:, None]
        value, slope = fade_value(u), fade_slope(u)
        scale = self.error_slope * span
        orders = [
            (self.error * value[k][:, None] + scale * slope[k][:, None]) / span**k for k in range(3)
        ]
        return orders[0], orders[1], orders[2]

    def _displaced(self, phase: np.ndarray) -> Orders:
        start, end = self.placement_span
        span = end - start
        way = np.einsum("njk,nk->nj", self.placement, self.displacement)
        # A leg that is aside has farther to go: the foot's height is kept to second order.
        way[:, _SLIDE] += (self.displacement**2).sum(axis=1) / (2 * self.lengths.nominal)
        share = smooth_step((phase - start) / span)
        return (
            way * share[0][:, None],
            way * share[1][:, None] / span,
            (way * share[2][:, None] / span**2),
        )


def phase_of(hip: NodeTable, position: np.ndarray) -> np.ndarray:
    """Phases (n,) at which the gaits' hips are at forward positions (n,) [m].

    Before the start and after the end of the step the hip goes almost straight on.
    """
    phase = _linear(hip.values[:, :, 0], position)
    for _ in range(_NEWTON):
        value, slope, _ = hip.at(phase)
        phase = phase + (position - value[:, 0]) / slope[:, 0]
    return phase


def phase_rate(hip: NodeTable, phase: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """ṡ (n,) [1/s] of hips with forward velocity (n,) [m/s] at phases (n,)."""
    return velocity / hip.at(phase)[1][:, 0]


def _linear(table: np.ndarray, position: np.ndarray) -> np.ndarray:
    """Piecewise linear inverse (n,) of increasing rows (n, K)."""
    pieces, rows = table.shape[1] - 1, np.arange(len(table))
    left = np.clip((table <= position[:, None]).sum(axis=1) - 1, 0, pieces - 1)
    width = table[rows, left + 1] - table[rows, left]
    return np.clip((left + (position - table[rows, left]) / width) / pieces, 0.0, 1.0)
