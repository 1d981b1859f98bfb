"""Whole-body control: joint torques that realise desired accelerations best, as a QP per robot.

Unknowns are the contact forces f and the accelerations of the actuated joints; the rest of q̈
follows from the unactuated rows of the equations of motion (base and upper feet), so that these
hold exactly: q̈ = T y + t with y = (f, q̈ₐ). The QP is min Σ w (J q̈ + J̇ q̇ − a)² + ρ y² subject to
friction pyramids inside the cones at both ends of each foot line and to the motors' torque-speed
limits.
"""

from dataclasses import dataclass, replace

import numpy as np

from slider.config.control import WholeBodyConfig
from slider.config.robot import RobotConfig
from slider.control.whole_body import qp
from slider.control.whole_body.nominal import NUM_DOFS, Dynamics
from slider.robot import names
from slider.robot.transmission import Transmission

_BASE = 6
_ACTUATED = np.array([_BASE + index for index in names.ACTUATED])
_UNACTUATED = np.array([i for i in range(NUM_DOFS) if i not in set(_ACTUATED)])
NUM_ACTUATED = len(_ACTUATED)
_JOINTS = np.array(names.ACTUATED)


@dataclass(frozen=True)
class Tasks:
    """Desired accelerations of n robots: J q̈ + bias = desired, per row.

    Attributes:
        jacobian: (n, r, 18).
        desired: (n, r) without the bias: acceleration − J̇ q̇.
        weight: (r,).
    """

    jacobian: np.ndarray
    desired: np.ndarray
    weight: np.ndarray


@dataclass(frozen=True)
class Problem:
    """One QP per robot: min ½ yᵀHy + gᵀy, lower ≤ (f, rows·y) ≤ upper; effort = map·y + offset.

    ``to_acceleration`` (n, 18, size + 1) gives q̈ from (y, 1).
    """

    hessian: np.ndarray
    gradient: np.ndarray
    rows: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    torque_map: np.ndarray
    torque_offset: np.ndarray
    to_acceleration: np.ndarray


class WholeBody:
    """Builds and solves the QPs of n robots that all have the same number of feet in stance."""

    def __init__(self, robot: RobotConfig, config: WholeBodyConfig) -> None:
        self._config = config
        self._half_line = np.array([-robot.geometry.heel, robot.geometry.toe])
        motors = Transmission.of(robot)
        self._motors = replace(motors, torque=config.effort_share * motors.torque)
        self._to_motors = motors.inverse[:, _JOINTS]

    def contact_jacobian(self, dynamics: Dynamics, feet: np.ndarray) -> np.ndarray:
        """Jacobian (n, 6 · feet, 18) of heel and toe of the stance ``feet`` (n, k)."""
        n, count = feet.shape
        robots = np.arange(n)[:, None]
        jacobian = dynamics.foot_jacobians[robots, feet]  # (n, k, 6, 18)
        along = dynamics.foot_rotations[robots, feet][..., 0]  # (n, k, 3)
        points = np.empty((n, count, 2, 3, NUM_DOFS))
        for axis in range(3):
            one, other = (axis + 1) % 3, (axis + 2) % 3
            turned = jacobian[:, :, 3 + one] * along[:, :, other, None]  # ω × r per unit length
            turned -= jacobian[:, :, 3 + other] * along[:, :, one, None]
            for end, length in enumerate(self._half_line):
                points[:, :, end, axis] = jacobian[:, :, axis] + length * turned
        return points.reshape(n, 6 * count, NUM_DOFS)

    def build(
        self, dynamics: Dynamics, tasks: Tasks, feet: np.ndarray, loaded: np.ndarray
    ) -> Problem:
        """QPs of n robots with ``feet`` (n, k) in stance; those not ``loaded`` get no force."""
        contact = self.contact_jacobian(dynamics, feet)
        transform = self._eliminate(dynamics, contact)
        hessian, gradient = self._cost(tasks, transform)
        ranks = contact.shape[1]
        map_, offset = self._torques(dynamics, contact, transform)
        low, high = self._motors.torque_limits(self._motors.angles(dynamics.qvel[:, _BASE:]))
        torque, still = self._to_motors @ map_, offset @ self._to_motors.T
        cone = self._cone(ranks)
        n = len(map_)
        rows = np.concatenate([torque, np.broadcast_to(cone, (n, *cone.shape))], axis=1)
        force_low, force_high = self._force_bounds(loaded)
        zero = np.zeros((n, len(cone)))
        lower = np.concatenate([force_low, low - still, zero - qp.UNBOUNDED], axis=1)
        upper = np.concatenate([force_high, high - still, zero], axis=1)
        return Problem(hessian, gradient, rows, lower, upper, map_, offset, transform)

    def _eliminate(self, dynamics: Dynamics, contact: np.ndarray) -> np.ndarray:
        """q̈ (n, 18) as a linear function of (f, q̈ₐ, 1)."""
        n, ranks = contact.shape[:2]
        mass, bias = dynamics.mass_matrix, dynamics.bias
        right = np.empty((n, len(_UNACTUATED), ranks + NUM_ACTUATED + 1))
        right[:, :, :ranks] = contact[:, :, _UNACTUATED].swapaxes(1, 2)
        right[:, :, ranks:-1] = -mass[:, _UNACTUATED[:, None], _ACTUATED]
        right[:, :, -1] = -bias[:, _UNACTUATED]
        transform = np.zeros((n, NUM_DOFS, ranks + NUM_ACTUATED + 1))
        square = mass[:, _UNACTUATED[:, None], _UNACTUATED]
        transform[:, _UNACTUATED] = np.linalg.solve(square, right)
        transform[:, _ACTUATED, ranks + np.arange(NUM_ACTUATED)] = 1.0
        return transform

    def _cost(self, tasks: Tasks, transform: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        image = tasks.jacobian @ transform
        rows, offset = image[:, :, :-1], tasks.desired - image[:, :, -1]
        weighted = rows.swapaxes(1, 2) * tasks.weight
        hessian = weighted @ rows
        size = hessian.shape[1]
        damping = np.full(size, self._config.regularisation[1])
        damping[-NUM_ACTUATED:] = self._config.regularisation[0]
        hessian[:, np.arange(size), np.arange(size)] += damping
        return hessian, -(weighted @ offset[:, :, None])[..., 0]

    def _torques(
        self, dynamics: Dynamics, contact: np.ndarray, transform: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Torques (n, 10) of the actuated joints as a linear function of y."""
        ranks = contact.shape[1]
        image = dynamics.mass_matrix[:, _ACTUATED] @ transform
        image[:, :, :ranks] -= contact[:, :, _ACTUATED].swapaxes(1, 2)
        return image[:, :, :-1], image[:, :, -1] + dynamics.bias[:, _ACTUATED]

    def _cone(self, ranks: int) -> np.ndarray:
        """Rows (4 · points, size) of ±fx − μ' fz ≤ 0 and ±fy − μ' fz ≤ 0, μ' = μ/√2."""
        points = ranks // 3
        cone = np.zeros((4 * points, ranks + NUM_ACTUATED))
        for point in range(points):
            for row, (axis, sign) in enumerate(((0, 1), (0, -1), (1, 1), (1, -1))):
                cone[4 * point + row, 3 * point + axis] = sign
                cone[4 * point + row, 3 * point + 2] = -self._config.friction / np.sqrt(2)
        return cone

    def _force_bounds(self, loaded: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Bounds (n, 6 · feet) of the forces at heel and toe: a foot in the air has none."""
        largest = np.where(np.repeat(loaded, 2, axis=1), self._config.force_max, 0.0)
        upper = np.repeat(largest, 3, axis=1)
        lower = -upper
        lower[:, 2::3] = 0.0
        return lower, upper

    def solve(self, problem: Problem) -> tuple[np.ndarray, np.ndarray]:
        """Torques (n, 12) [N m or N] of all joints, and which robots (n,) have a solution."""
        found, solved = qp.solve(
            problem.hessian, problem.gradient, problem.rows, problem.lower, problem.upper
        )
        torques = np.zeros((len(found), names.NUM_JOINTS))
        torques[:, _JOINTS] = (problem.torque_map @ found[:, :, None])[..., 0]
        torques[:, _JOINTS] += problem.torque_offset
        torques[~solved] = 0.0
        return torques, solved
