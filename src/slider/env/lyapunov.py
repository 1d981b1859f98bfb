"""The control Lyapunov function of outputs whose dynamics are double integrators."""

import math
from dataclasses import dataclass

import numpy as np

from slider.core.arrays import Array


@dataclass(frozen=True)
class Lyapunov:
    """V = ηᵀPη of outputs y with ÿ = v, and η = (y, ẏ/ω) of each.

    P solves FᵀP + PF − PGR⁻¹GᵀP + Q = 0 with Q = diag(1, q) and R = 1, time in units of 1/ω:
    P = [[√(q + 2), 1], [1, √(q + 2)]]. In seconds these are Q = diag(1, q/ω²) and R = 1/ω⁴, whose P
    is that divided by ω. The LQR has the natural frequency ω and the damping √(q + 2)/2.

    Attributes:
        bandwidth: ω [rad/s].
        rate_weight: q.
    """

    bandwidth: float
    rate_weight: float

    @property
    def matrix(self) -> np.ndarray:
        """P (2, 2) of one output; that of all is block diagonal."""
        return np.eye(2) * np.sqrt(self.rate_weight + 2.0) + np.array([[0.0, 1.0], [1.0, 0.0]])

    @property
    def largest(self) -> float:
        """λ_max(P) = ‖P‖."""
        return math.sqrt(self.rate_weight + 2.0) + 1.0

    def value(self, outputs: Array) -> Array:
        """V (N,) of outputs (N, 2, K), K values [rad] and their rates [rad/s]; in rad²."""
        y, rate = outputs[:, 0], outputs[:, 1] / self.bandwidth
        diagonal = self.largest - 1.0
        return (diagonal * (y**2 + rate**2) + 2.0 * y * rate).sum(axis=1)
