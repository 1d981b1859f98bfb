"""Coordinates in which bodies move: the slide's, or the virtual knee's of the constraints.

Gaits are polynomials in the knee's joints. Eq. 1 (exact) gives those of the slide as functions of
time: q̈_p = J q̈_k + J̇ q̇_k, and by virtual work τ_k = Jᵀ τ_p.
"""

from dataclasses import dataclass

import numpy as np

from slider.config.robot import Mechanism
from slider.robot import knee_map
from slider.robot.names import ACTUATED, KNEE_LEG_JOINTS, SIDES

LEG = len(KNEE_LEG_JOINTS)
_STARTS = LEG * np.arange(len(SIDES))
_PITCH, _KNEE, _ANKLE = (
    _STARTS + KNEE_LEG_JOINTS.index(name) for name in ("hip_pitch", "knee", "ankle")
)
_DRIVEN = np.array(ACTUATED)

Motion = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Positions, velocities and accelerations (..., 10) [rad, m]."""


def driven(joints: np.ndarray) -> np.ndarray:
    """Values of the driven joints (..., 10) of all (..., 12)."""
    return joints[..., _DRIVEN]


@dataclass(frozen=True)
class SlideMap:
    """Eq. 1, exact, of lengths l1 and l2 and of the leg's length at slide = 0 [m]."""

    l1: float
    l2: float
    nominal: float

    @classmethod
    def of(cls, robot: Mechanism) -> "SlideMap":
        """The map of a robot."""
        knee = robot.virtual_knee
        return cls(knee.thigh_length, knee.shank_length, robot.geometry.leg_length)

    def motion(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> Motion:
        """Motion of the prismatic legs of a motion of the knee legs."""
        place, rate = self.sampled(q, v, "exact")
        turn = np.einsum("...ij,...j->...i", self.jacobian(q), a)
        hip, slide = self._curvatures(q[..., _KNEE])
        for joint, bend in ((_PITCH, hip), (_KNEE, slide), (_ANKLE, -hip)):
            turn[..., joint] += bend * v[..., _KNEE] ** 2
        return place, rate, turn

    def sampled(self, q: np.ndarray, v: np.ndarray, variant: str) -> tuple[np.ndarray, np.ndarray]:
        """Positions and velocities (..., 10) as a ``kinematic_map`` of eq. 1 converts them."""
        theta, lengths = q[..., _KNEE], (self.l1, self.l2, variant)
        at = knee_map.positions(q[..., _PITCH], theta, q[..., _ANKLE], *lengths)
        to = knee_map.velocities(v[..., _PITCH], theta, v[..., _KNEE], v[..., _ANKLE], *lengths)
        place, rate = q.copy(), v.copy()
        place[..., _KNEE], rate[..., _KNEE] = at.length - self.nominal, to.length
        for joint, name in ((_PITCH, "hip_pitch"), (_ANKLE, "ankle")):
            place[..., joint], rate[..., joint] = getattr(at, name), getattr(to, name)
        return place, rate

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        """Derivatives (..., 10, 10) of the prismatic legs' joints by the knee legs'."""
        matrix = np.tile(np.eye(q.shape[-1]), (*q.shape[:-1], 1, 1))
        hip, ankle, slide = knee_map.rates(q[..., _KNEE], self.l1, self.l2)
        for joint, slope in ((_PITCH, -hip), (_KNEE, slide), (_ANKLE, -ankle)):
            matrix[..., joint, _KNEE] = slope
        return matrix

    def _curvatures(self, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Second derivatives of hip pitch and slide by the knee angle; the ankle's is −hip's."""
        l1, l2, sine = self.l1, self.l2, np.sin(theta)
        length = knee_map.leg_length(theta, l1, l2)
        hip = l1 * l2 * sine * (l1**2 - l2**2) / length**4
        return hip, -l1 * l2 * (np.cos(theta) / length + l1 * l2 * sine**2 / length**3)


@dataclass(frozen=True)
class SlideCoordinates:
    """The bodies move with the prismatic legs; ``map`` leads from the knee legs to them."""

    map: SlideMap

    def motion(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> Motion:
        """Motion of the robot's own joints of a motion of the knee legs (..., 10): eq. 1."""
        return self.map.motion(q, v, a)

    def work(self, q: np.ndarray, forces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Torques of the knee's joints, efforts of the slide's (10,) of forces at its own.

        τ_k = Jᵀ τ_p at positions q of the knee legs.
        """
        return self.map.jacobian(q).T @ forces, forces


@dataclass(frozen=True)
class KneeCoordinates:
    """The bodies move with the virtual knee."""

    map: SlideMap

    def motion(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> Motion:
        """As :meth:`SlideCoordinates.motion`: the knee's own."""
        return q, v, a

    def work(self, q: np.ndarray, forces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """As :meth:`SlideCoordinates.work`: τ_p = J⁻ᵀ τ_k."""
        return forces, np.linalg.solve(self.map.jacobian(q).T, forces)


Coordinates = SlideCoordinates | KneeCoordinates
"""What the dynamics of a robot are written in."""
