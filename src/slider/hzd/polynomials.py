"""Polynomials of a step's phase: fading of an initial error, onset of a displacement, tables."""

from dataclasses import dataclass

import numpy as np

from slider.core.compiled import compiled, part

Orders = tuple[np.ndarray, np.ndarray, np.ndarray]
"""A value and its first and second derivatives."""

_BEFORE = -0.25  # a phase that turns back after an impact meets the same polynomials


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


_EASE = 0.1  # of a step


@compiled
def extended(inside: Orders, beyond: np.ndarray) -> Orders:
    """Values (n, m), with two derivatives, ``beyond`` (n,) the phases at which they are known.

    The curvature fades linearly to zero, then the motion goes straight on: all three are
    continuous, so that a return map has a derivative where steps end at the end of the phase.
    """
    value, slope, curve = inside
    orders = np.empty_like(value), np.empty_like(value), np.empty_like(value)
    for robot in range(value.shape[0]):
        for k in range(value.shape[1]):
            here = value[robot, k], slope[robot, k], curve[robot, k]
            orders[0][robot, k], orders[1][robot, k], orders[2][robot, k] = _onward(
                here, beyond[robot]
            )
    return orders


@part
def _onward(here: tuple[float, float, float], beyond: float) -> tuple[float, float, float]:
    value, slope, curve = here
    ahead = abs(beyond)
    u = min(ahead / _EASE, 1.0)
    turned = _EASE * (u - u**2 / 2)
    moved = _EASE**2 * (u**2 / 2 - u**3 / 6) + turned * (ahead - _EASE * u)
    bent = np.sign(beyond) * turned
    return value + beyond * slope + moved * curve, slope + bent * curve, (1.0 - u) * curve


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

    @property
    def orders(self) -> list[np.ndarray]:
        """The arrays that there are."""
        return [a for a in (self.values, self.slopes, self.curvatures) if a is not None]

    def of(self, rows: np.ndarray) -> "NodeTable":
        """The tables of some of the robots, in a given order."""
        return NodeTable(*(array[rows] for array in self.orders))

    def at(self, phase: np.ndarray) -> Orders:
        """Hermite interpolation (n, m) at phases (n,), and its derivatives.

        Outside [0, 1] it goes on as ``extended`` does.
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
        # A robot that is lost has no phase, and gets no value.
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
            orders[0][robot, k], orders[1][robot, k], orders[2][robot, k] = _onward(
                inside, phase[robot] - within
            )
    return orders
