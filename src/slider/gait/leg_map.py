"""Eq. 1 (exact) as a symbolic change of coordinates: from the virtual knee's to the slide's.

q_p = φ(q_k), q̇_p = J q̇_k, q̈_p = J q̈_k + J̇ q̇_k, and by virtual work τ_k = Jᵀ τ_p.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import casadi as ca

from slider.config.robot import VirtualKnee
from slider.robot.names import KNEE_LEG_JOINTS

LEG_JOINTS = len(KNEE_LEG_JOINTS)
PITCH, KNEE, ANKLE = 2, 3, 4


@dataclass(frozen=True)
class LegMap:
    """Hip pitch, leg length and ankle of the prismatic leg over the knee's flexion θ.

    Attributes:
        shifts: θ → what adds to (hip pitch, 0, ankle) and the leg length (3,) [rad, m, rad].
        slopes, curvatures: first and second derivatives of these by θ.
        nominal: leg length at slide = 0 [m].
    """

    shifts: ca.Function
    slopes: ca.Function
    curvatures: ca.Function
    nominal: float

    @classmethod
    def of(cls, knee: VirtualKnee, leg_length: float) -> "LegMap":
        """The map of a virtual knee."""
        l1, l2 = knee.thigh_length, knee.shank_length
        theta = ca.SX.sym("theta")
        hip = ca.atan2(l2 * ca.sin(theta), l1 + l2 * ca.cos(theta))
        length = ca.sqrt(l1**2 + l2**2 + 2 * l1 * l2 * ca.cos(theta))
        values = ca.vertcat(-hip, length, hip - theta)
        slopes = ca.jacobian(values, theta)
        return cls(
            ca.Function("shifts", [theta], [values]),
            ca.Function("slopes", [theta], [slopes]),
            ca.Function("curvatures", [theta], [ca.jacobian(slopes, theta)]),
            leg_length,
        )

    def positions(self, q: ca.SX) -> ca.SX:
        """Joint positions of the prismatic legs of knee legs (5 per leg)."""
        parts = []
        for (leg,) in _legs(q):
            hip, length, ankle = ca.vertsplit(self.shifts(leg[KNEE]))
            parts += [leg[:PITCH], leg[PITCH] + hip, length - self.nominal, leg[ANKLE] + ankle]
        return ca.vertcat(*parts)

    def velocities(self, q: ca.SX, v: ca.SX) -> ca.SX:
        """Joint velocities of the prismatic legs."""
        return self._apply(q, v, self.slopes)

    def accelerations(self, q: ca.SX, v: ca.SX, a: ca.SX) -> ca.SX:
        """Joint accelerations of the prismatic legs."""
        parts = []
        for leg, rate in _legs(q, v):
            hip, slide, ankle = ca.vertsplit(self.curvatures(leg[KNEE]) * rate[KNEE] ** 2)
            parts += [ca.SX.zeros(PITCH), hip, slide, ankle]
        return self._apply(q, a, self.slopes) + ca.vertcat(*parts)

    def _apply(self, q: ca.SX, v: ca.SX, slopes: ca.Function) -> ca.SX:
        parts = []
        for leg, rate in _legs(q, v):
            hip, slide, ankle = ca.vertsplit(slopes(leg[KNEE]) * rate[KNEE])
            parts += [rate[:PITCH], rate[PITCH] + hip, slide, rate[ANKLE] + ankle]
        return ca.vertcat(*parts)

    def knee_torques(self, q: ca.SX, efforts: ca.SX) -> ca.SX:
        """Torques of the knee legs that do the work of prismatic efforts: Jᵀ τ_p."""
        parts = []
        for leg, effort in _legs(q, efforts):
            knee = ca.dot(self.slopes(leg[KNEE]), effort[PITCH:])
            parts += [effort[:KNEE], knee, effort[ANKLE]]
        return ca.vertcat(*parts)

    def efforts(self, q: ca.SX, torques: ca.SX) -> ca.SX:
        """Prismatic efforts that do the work of the knee legs' torques: J⁻ᵀ τ_k."""
        parts = []
        for leg, torque in _legs(q, torques):
            hip, slide, ankle = ca.vertsplit(self.slopes(leg[KNEE]))
            force = (torque[KNEE] - hip * torque[PITCH] - ankle * torque[ANKLE]) / slide
            parts += [torque[:KNEE], force, torque[ANKLE]]
        return ca.vertcat(*parts)


def _legs(*joints: ca.SX) -> Iterator[tuple[ca.SX, ...]]:
    """Values of each leg (5,) of values of both (10,)."""
    return zip(*(ca.vertsplit(each, LEG_JOINTS) for each in joints), strict=True)
