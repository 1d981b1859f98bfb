"""Polynomials of a step's phase: fading of an initial error, onset of a displacement, tables."""

from dataclasses import dataclass

import numpy as np

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


def extended(inside: Orders, beyond: np.ndarray) -> Orders:
    """Values (n, m), with two derivatives, ``beyond`` (n,) the phases at which they are known.

    The curvature fades linearly to zero, then the motion goes straight on: all three are
    continuous, so that a return map has a derivative where steps end at the end of the phase.
    """
    value, slope, curve = inside
    ahead = np.abs(beyond)
    u = np.minimum(ahead / _EASE, 1.0)
    turned = _EASE * (u - u**2 / 2)
    moved = _EASE**2 * (u**2 / 2 - u**3 / 6) + turned * (ahead - _EASE * u)
    turned, moved, left = ((f[:, None]) for f in (np.sign(beyond) * turned, moved, 1.0 - u))
    return value + beyond[:, None] * slope + moved * curve, slope + turned * curve, left * curve


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
        within = np.clip(phase, 0.0, 1.0)
        return extended(self._within(within), phase - within)

    def _within(self, phase: np.ndarray) -> Orders:
        pieces = self.values.shape[1] - 1
        place = phase * pieces
        # A robot that is lost has no phase, and gets no value.
        left = np.fmin(place, pieces - 1).astype(int)
        u, rows = (place - left)[:, None], np.arange(len(phase))
        ends = [rows, left], [rows, left + 1]
        a, b = (self.values[tuple(end)] for end in ends)
        da, db = (self.slopes[tuple(end)] / pieces for end in ends)
        if self.curvatures is None:
            c2, c3 = 3 * (b - a) - 2 * da - db, 2 * (a - b) + da + db
            factors = [a, da, c2, c3]
        else:
            dda, ddb = (self.curvatures[tuple(end)] / pieces**2 for end in ends)
            rise, rate, bend = b - a - da - dda / 2, db - da - dda, ddb - dda
            c3 = 10 * rise - 4 * rate + bend / 2
            c4 = -15 * rise + 7 * rate - bend
            c5 = 6 * rise - 3 * rate + bend / 2
            factors = [a, da, dda / 2, c3, c4, c5]
        powers = [u**k for k in range(len(factors))]
        value = sum(c * power for c, power in zip(factors, powers, strict=True))
        rising, bending = list(enumerate(factors))[1:], list(enumerate(factors))[2:]
        slope = sum(k * c * power for (k, c), power in zip(rising, powers, strict=False))
        curve = sum(k * (k - 1) * c * power for (k, c), power in zip(bending, powers, strict=False))
        return np.asarray(value), np.asarray(slope) * pieces, np.asarray(curve) * pieces**2
