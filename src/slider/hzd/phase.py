"""The phase as a monotone function of the state: where the hip is, forward of the stance foot.

A gait passes each place once, so that its place tells the phase: s = σ(p) with σ the inverse of
the gait's own p(s). Along the gait it is the normalised time, and the same polynomials serve both.
As in partial hybrid zero dynamics (Ames, "Human-inspired control of bipedal walking robots", IEEE
TAC 59(5), 2014), a velocity output then drives the phase: ṡ → 1/T.
"""

import numpy as np

from slider.hzd.polynomials import NodeTable

_NEWTON = 4  # steps from the linear guess; the table is smooth


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
