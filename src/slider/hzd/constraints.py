"""Virtual constraints of a step of n robots: the gait's motion, re-anchored, with foot placement.

x_d(s) = X(s) + c(s) + D b(s) over the phase s in [0, 1]. X is the gait: Bézier polynomials of the
virtual leg through eq. 1, and the roll of the stance foot. c re-anchors the constraints after an
impact: it starts with the error that the impact left, in position and velocity, and is gone by
mid-step (Morris and Grizzle, "Hybrid invariant manifolds in systems with impulse effects with
application to periodic locomotion in bipedal robots", IEEE TAC 54(8), 2009). D moves the swing
foot horizontally by b [m].
"""

from dataclasses import dataclass, field

import numpy as np

from slider.config.hzd import VirtualConstraintsConfig
from slider.core.compiled import compiled, part
from slider.gait import bezier
from slider.gait.outputs import JOINTS, NUM_COORDINATES, ROLL, SWING
from slider.robot.knee_map import KneeLengths, prismatic_motion

Orders = tuple[np.ndarray, np.ndarray, np.ndarray]
"""A value and its first and second derivatives."""

_SLIDE = SWING - JOINTS + 3  # of the swing leg, among the joints
_LEAST = 0.2  # a correction lasts at least this share of a step
_NEWTON = 4  # steps from the linear guess of a phase; the table is smooth
_BEFORE = -0.25  # least argument of a fade; after an impact the phase may move backward
_EASE = 0.1  # share of a step over which the curvature of the extrapolation fades


@dataclass(frozen=True)
class NodeTable:
    """Quantities of n robots at K equally spaced phases, with their derivatives over the phase.

    Attributes:
        values, slopes: (n, K, m).
        curvatures: (n, K, m), or none: then cubic instead of quintic between the nodes.
    """

    values: np.ndarray
    slopes: np.ndarray
    curvatures: np.ndarray | None = None

    def at(self, phase: np.ndarray) -> Orders:
        """Hermite interpolation (n, m) at phases (n,), and its derivatives.

        Outside [0, 1] it is continued like ``extrapolated``.
        """
        return _interpolated(self.values, self.slopes, self.curvatures, phase)


@compiled
def _interpolated(
    values: np.ndarray, slopes: np.ndarray, curvatures: np.ndarray | None, phase: np.ndarray
) -> Orders:
    shape, pieces = (values.shape[0], values.shape[2]), values.shape[1] - 1
    orders = np.empty(shape), np.empty(shape), np.empty(shape)
    for robot in range(shape[0]):
        within = min(max(phase[robot], 0.0), 1.0)
        place = within * pieces
        # The phase of a lost robot is NaN, and so are its values.
        left = int(place) if place < pieces else pieces - 1
        u = place - left
        for k in range(shape[1]):
            a, b = values[robot, left, k], values[robot, left + 1, k]
            da, db = slopes[robot, left, k] / pieces, slopes[robot, left + 1, k] / pieces
            if curvatures is None:
                dda = 6 * (b - a) - 4 * da - 2 * db
                c3, c4, c5 = 2 * (a - b) + da + db, 0.0, 0.0
            else:
                dda = curvatures[robot, left, k] / pieces**2
                ddb = curvatures[robot, left + 1, k] / pieces**2
                rise, rate, bend = b - a - da - dda / 2, db - da - dda, ddb - dda
                c3 = 10 * rise - 4 * rate + bend / 2
                c4 = -15 * rise + 7 * rate - bend
                c5 = 6 * rise - 3 * rate + bend / 2
            value = a + u * (da + u * (dda / 2 + u * (c3 + u * (c4 + u * c5))))
            slope = da + u * (dda + u * (3 * c3 + u * (4 * c4 + u * 5 * c5)))
            curve = dda + u * (6 * c3 + u * (12 * c4 + u * 20 * c5))
            inside = value, slope * pieces, curve * pieces**2
            orders[0][robot, k], orders[1][robot, k], orders[2][robot, k] = _extrapolated(
                inside, phase[robot] - within
            )
    return orders


@dataclass(frozen=True)
class Steps:
    """One step of each of n gaits, in reflected coordinates.

    Attributes:
        coefficients: Bézier coefficients of the virtual legs (n, 10, degree + 1) [rad].
        roll: of the stance foot's line (m = 1) [rad] over the phase.
        placement: D (n, 10, 2), joints that move the swing foot forward and left [rad/m, m/m].
        lengths: of the virtual leg, if gaits have one.
        slide_length: of a leg at slide = 0 [m]; None for a leg with a knee.
    """

    coefficients: np.ndarray
    roll: NodeTable
    placement: np.ndarray
    lengths: KneeLengths | None
    slide_length: float | None

    def constraints(self, config: VirtualConstraintsConfig) -> "StepConstraints":
        """Virtual constraints of these steps."""
        span = config.placement.lower, config.placement.upper
        return StepConstraints(self, config.correction_end, span)


@dataclass
class StepConstraints:
    """Constraints of the steps that n robots are making, stance leg first.

    Attributes:
        steps: of the gaits.
        correction_end: phase at which the re-anchoring is over.
        placement_span: phases between which the foot is displaced.
        anchor: (n,) phase at which the last impact left the errors.
        error, error_slope: (n, 12) of the coordinates then, and their derivative over the phase.
        displacement: b (n, 2) forward and left in the stance foot's reflected frame [m].
    """

    steps: Steps
    correction_end: float
    placement_span: tuple[float, float]
    anchor: np.ndarray = field(init=False)
    error: np.ndarray = field(init=False)
    error_slope: np.ndarray = field(init=False)
    displacement: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        n = len(self.steps.coefficients)
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

        Before the start and after the end of the step the motion is extrapolated.
        """
        within = np.clip(phase, 0.0, 1.0)
        value, slope, curve = extrapolated(self._gait(within), phase - within)
        orders = value, slope, curve
        corrections, moves = self._correction(phase), self._displaced(phase)
        for order, correction, move in zip(orders, corrections, moves, strict=True):
            order += correction
            order[:, JOINTS:] += move
        return orders

    def _gait(self, phase: np.ndarray) -> Orders:
        steps = self.steps
        basis = bezier.basis_orders(steps.coefficients.shape[2] - 1, phase, 3)
        q, v, a = (np.einsum("nk,njk->nj", each, steps.coefficients) for each in basis)
        legs, rolls = prismatic_motion(q, v, a, steps.lengths), steps.roll.at(phase)
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
        (start, end), length = self.placement_span, self.steps.slide_length
        span = end - start
        way = np.einsum("njk,nk->nj", self.steps.placement, self.displacement)
        # A leg that is displaced must be longer: a slide keeps the foot's height to second order.
        if length is not None:
            way[:, _SLIDE] += (self.displacement**2).sum(axis=1) / (2 * length)
        share = smooth_step((phase - start) / span)
        value, slope, curve = (way * order[:, None] for order in share)
        return value, slope / span, curve / span**2


def phase_of(hip: NodeTable, position: np.ndarray) -> np.ndarray:
    """Phases (n,) at which the gaits' hips are at forward positions (n,) [m].

    Before the start and after the end of the step the hip's motion is extrapolated.
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


def fade_value(u: np.ndarray) -> Orders:
    """One at u = 0 with slope zero, zero with two derivatives at u = 1: (1 − u)³ (1 + 3u)."""
    u = np.clip(u, _BEFORE, 1.0)
    rest = 1.0 - u
    return rest**3 * (1 + 3 * u), -12 * u * rest**2, rest * (36 * u - 12)


def fade_slope(u: np.ndarray) -> Orders:
    """Zero at u = 0 with slope one, zero with two derivatives at u = 1: u (1 − u)³."""
    u = np.clip(u, _BEFORE, 1.0)
    rest = 1.0 - u
    return u * rest**3, rest**2 * (1 - 4 * u), rest * (12 * u - 6)


def smooth_step(u: np.ndarray) -> Orders:
    """From zero to one with two zero derivatives at both ends: u³ (10 − 15u + 6u²)."""
    u = np.clip(u, 0.0, 1.0)
    rest = 1.0 - u
    return u**3 * (10 - 15 * u + 6 * u**2), 30 * u**2 * rest**2, 60 * u * rest * (1 - 2 * u)


@compiled
def extrapolated(inside: Orders, beyond: np.ndarray) -> Orders:
    """Extrapolate values (n, m), with two derivatives, by ``beyond`` (n,) in phase.

    The curvature fades linearly to zero, then the motion is linear: all three are continuous, so
    that a return map is differentiable where steps end at phase 1.
    """
    value, slope, curve = inside
    orders = np.empty_like(value), np.empty_like(value), np.empty_like(value)
    for robot in range(value.shape[0]):
        for k in range(value.shape[1]):
            here = value[robot, k], slope[robot, k], curve[robot, k]
            orders[0][robot, k], orders[1][robot, k], orders[2][robot, k] = _extrapolated(
                here, beyond[robot]
            )
    return orders


@part
def _extrapolated(here: tuple[float, float, float], beyond: float) -> tuple[float, float, float]:
    value, slope, curve = here
    ahead = abs(beyond)
    u = min(ahead / _EASE, 1.0)
    turned = _EASE * (u - u**2 / 2)
    moved = _EASE**2 * (u**2 / 2 - u**3 / 6) + turned * (ahead - _EASE * u)
    bent = np.sign(beyond) * turned
    return value + beyond * slope + moved * curve, slope + bent * curve, (1.0 - u) * curve
