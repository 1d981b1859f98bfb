"""Whole-body control: joint torques that realise desired accelerations best, as a QP per robot.

Unknowns are the contact forces f and the accelerations of the actuated joints; the rest of q̈
follows from the unactuated rows of the equations of motion (base and upper feet), so that these
hold exactly: q̈ = T y + t with y = (f, q̈ₐ). The QP is min Σ w (J q̈ + J̇ q̇ − a)² + ρ y² subject to
friction pyramids inside the cones at both ends of each foot line, or the corners of each sole, and
to the motors' torque-speed limits.
"""

from dataclasses import dataclass, replace

import numpy as np

from slider.config.control import WholeBodyConfig
from slider.config.robot import RobotConfig
from slider.control import qp
from slider.control.whole_body.model import NUM_DOFS, Dynamics
from slider.core.compiled import compiled, part
from slider.robot import names
from slider.robot.transmission import Transmission

_BASE = 6


Task = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Rows r of n robots: Jacobian (n, r, 18), desired J q̈ (n, r), the acceleration less the bias
J̇ q̇, and weight (r,)."""


@dataclass(frozen=True)
class Problem:
    """One QP per robot: min ½ yᵀHy + gᵀy, lower ≤ (f, rows·y) ≤ upper.

    ``efforts`` (n, actuated, size + 1) maps (y, 1) to the efforts of the actuated joints.
    """

    hessian: np.ndarray
    gradient: np.ndarray
    rows: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    efforts: np.ndarray


class WholeBody:
    """Builds and solves the QPs of n robots that all have the same number of feet in stance."""

    def __init__(self, robot: RobotConfig, config: WholeBodyConfig) -> None:
        self._config = config
        geometry, motors = robot.geometry, Transmission.of(robot)
        sides = (0.0,) if geometry.sole is None else np.array([-0.5, 0.5]) * geometry.sole.width
        # Points on the ground in the frame of the foot, forward and leftward.
        self._points = np.array([[x, y] for x in (-geometry.heel, geometry.toe) for y in sides])
        self._joints = np.array(names.driven_joints(geometry))
        actuated = _BASE + self._joints
        self._dofs = actuated, np.setdiff1d(np.arange(NUM_DOFS), actuated)
        self._motors = replace(motors, torque=config.effort_share * motors.torque)
        self._to_motors = motors.inverse[:, self._joints].copy()

    def contact_jacobian(self, dynamics: Dynamics, feet: np.ndarray) -> np.ndarray:
        """Jacobian (n, 3 · points, 18) of ends or corners of the stance ``feet`` (n, k)."""
        points = np.empty((*feet.shape, len(self._points), 3, NUM_DOFS))
        terms = dynamics.foot_jacobians, dynamics.foot_rotations
        _ground_points(*terms, feet, self._points, points)
        return points.reshape(len(feet), -1, NUM_DOFS)

    def build(
        self,
        dynamics: Dynamics,
        tasks: list[Task],
        feet: np.ndarray,
        loaded: np.ndarray,
        idle: np.ndarray | None = None,
    ) -> Problem:
        """QPs of n robots with ``feet`` (n, k) in stance; those not ``loaded`` get no force.

        Motors that are ``idle`` (n, m) have no torque.
        """
        contact, actuated = self.contact_jacobian(dynamics, feet), len(self._joints)
        n, num_forces = contact.shape[:2]
        size, cone = num_forces + actuated, self._cone(num_forces)
        hessian, gradient = np.empty((n, size, size)), np.empty((n, size))
        efforts = np.empty((n, actuated, size + 1))
        rows, offset = np.empty((n, actuated + len(cone), size)), np.empty((n, actuated))
        rows[:, actuated:] = cone
        terms = dynamics.mass_matrix, dynamics.bias, contact
        jacobians, desired, weights = zip(*tasks, strict=True)
        targets = np.concatenate(jacobians, 1), np.concatenate(desired, 1)
        accelerations, forces = self._config.regularisation
        settings = np.repeat([forces, accelerations], [num_forces, actuated]), self._to_motors
        _reduce(
            terms,
            (*targets, np.sqrt(np.concatenate(weights))),
            settings,
            self._dofs,
            hessian,
            gradient,
            efforts,
            rows,
            offset,
        )
        low, high = self._motors.torque_limits(self._motors.angles(dynamics.qvel[:, _BASE:]))
        if idle is not None:
            low, high = np.where(idle, 0.0, low), np.where(idle, 0.0, high)
        largest = np.where(loaded, self._config.force_max, 0.0)
        largest = np.repeat(largest, len(self._points), axis=1)
        force_high = np.repeat(largest, 3, axis=1)  # at each point; none of a foot in the air
        force_low = -force_high
        force_low[:, 2::3] = 0.0
        zero = np.zeros((n, len(cone)))
        lower = np.concatenate([force_low, low - offset, zero - qp.UNBOUNDED], axis=1)
        upper = np.concatenate([force_high, high - offset, zero], axis=1)
        return Problem(hessian, gradient, rows, lower, upper, efforts)

    def _cone(self, num_forces: int) -> np.ndarray:
        """Rows (4 · points, size) of ±fx − μ' fz ≤ 0 and ±fy − μ' fz ≤ 0, μ' = μ/√2."""
        points = num_forces // 3
        cone = np.zeros((4 * points, num_forces + len(self._joints)))
        for point in range(points):
            for row, (axis, sign) in enumerate(((0, 1), (0, -1), (1, 1), (1, -1))):
                cone[4 * point + row, 3 * point + axis] = sign
                cone[4 * point + row, 3 * point + 2] = -self._config.friction / np.sqrt(2)
        return cone

    def solve(self, problem: Problem) -> tuple[np.ndarray, np.ndarray]:
        """Torques (n, 12) [N m or N] of all joints, and which robots (n,) have a solution."""
        minimisers, solved = qp.solve(
            problem.hessian, problem.gradient, problem.rows, problem.lower, problem.upper
        )
        torques = np.zeros((len(minimisers), names.NUM_JOINTS))
        maps, offsets = problem.efforts[:, :, :-1], problem.efforts[:, :, -1]
        torques[:, self._joints] = (maps @ minimisers[:, :, None])[..., 0] + offsets
        torques[~solved] = 0.0
        return torques, solved


@compiled
def _ground_points(
    jacobians: np.ndarray,
    rotations: np.ndarray,
    feet: np.ndarray,
    offsets: np.ndarray,
    points: np.ndarray,
) -> None:
    """Points (n, k, p, 3, 18) at ``offsets`` (p, 2) forward and leftward on a foot: J + ω × r."""
    for robot in range(len(feet)):
        for place, foot in enumerate(feet[robot]):
            jacobian, axes = jacobians[robot, foot], rotations[robot, foot]
            for point in range(len(offsets)):
                for axis in range(3):
                    one, other = (axis + 1) % 3, (axis + 2) % 3
                    for dof in range(NUM_DOFS):
                        value = jacobian[axis, dof]
                        for side in range(2):
                            if offsets[point, side] != 0.0:
                                turned = jacobian[3 + one, dof] * axes[other, side]
                                turned -= jacobian[3 + other, dof] * axes[one, side]
                                value += offsets[point, side] * turned
                        points[robot, place, point, axis, dof] = value


_Arrays = tuple[np.ndarray, np.ndarray, np.ndarray]


@compiled
def _reduce(
    terms: _Arrays,
    targets: _Arrays,
    settings: tuple[np.ndarray, np.ndarray],
    dofs: tuple[np.ndarray, np.ndarray],
    hessian: np.ndarray,
    gradient: np.ndarray,
    efforts: np.ndarray,
    rows: np.ndarray,
    offset: np.ndarray,
) -> None:
    """Cost, efforts and motor torques ``rows`` y + ``offset`` in the unknowns y = (f, q̈ₐ).

    With q̈ᵤ = S (y, 1), the cost is Σ (√w (Jᵤ S y + Jₐ q̈ₐ − b))² + ρ y² and the efforts are
    Mₐᵤ S y + Mₐₐ q̈ₐ + hₐ − Jₐᵀ f.
    """
    (mass, bias, contact), (jacobian, desired, root_weight), (damping, to_motors) = (
        terms,
        targets,
        settings,
    )
    actuated = len(dofs[0])
    size, count, free = hessian.shape[1], len(root_weight), len(dofs[1])
    mass_uu, unactuated = np.empty((free, free)), np.empty((free, size + 1))  # Mᵤᵤ, S
    columns, weighted, target = np.empty((count, free)), np.empty((count, size)), np.empty(count)
    product, coupling = np.empty((count, size + 1)), np.empty((actuated, free))
    motors, mass_rows = np.empty((actuated, size + 1)), np.empty((actuated, NUM_DOFS))
    for robot in range(len(mass)):
        _eliminate(mass[robot], bias[robot], contact[robot], dofs, mass_uu, unactuated)
        _multiply(jacobian[robot], dofs, unactuated, columns, product)
        for row in range(count):
            for column in range(size):
                weighted[row, column] = root_weight[row] * product[row, column]
            target[row] = root_weight[row] * (desired[robot, row] - product[row, size])
        np.dot(weighted.T, weighted, hessian[robot])
        np.dot(weighted.T, target, gradient[robot])
        for place in range(size):
            hessian[robot, place, place] += damping[place]
            gradient[robot, place] *= -1.0
        effort = efforts[robot]
        for row, joint in enumerate(dofs[0]):
            for dof in range(NUM_DOFS):
                mass_rows[row, dof] = mass[robot, joint, dof]
        _multiply(mass_rows, dofs, unactuated, coupling, effort)
        for row, joint in enumerate(dofs[0]):
            for column in range(contact.shape[1]):
                effort[row, column] -= contact[robot, column, joint]
            effort[row, size] += bias[robot, joint]
        np.dot(to_motors, effort, motors)
        for row in range(actuated):
            for column in range(size):
                rows[robot, row, column] = motors[row, column]
            offset[robot, row] = motors[row, size]


@part
def _multiply(
    matrix: np.ndarray,
    dofs: tuple[np.ndarray, np.ndarray],
    unactuated: np.ndarray,
    columns: np.ndarray,
    product: np.ndarray,
) -> None:
    """``matrix`` (r, 18) q̈ of (f, q̈ₐ, 1), through its ``columns`` of q̈ᵤ."""
    first = unactuated.shape[1] - 1 - len(dofs[0])
    for row in range(len(matrix)):
        for place, dof in enumerate(dofs[1]):
            columns[row, place] = matrix[row, dof]
    np.dot(columns, unactuated, product)
    for row in range(len(matrix)):
        for place, dof in enumerate(dofs[0]):
            product[row, first + place] += matrix[row, dof]


@part
def _eliminate(
    mass: np.ndarray,
    bias: np.ndarray,
    contact: np.ndarray,
    dofs: tuple[np.ndarray, np.ndarray],
    mass_uu: np.ndarray,
    unactuated: np.ndarray,
) -> None:
    """Unactuated accelerations q̈ᵤ = S (f, q̈ₐ, 1): Mᵤᵤ S = (Jᵤᵀ, −Mᵤₐ, −hᵤ)."""
    num_forces = len(contact)
    for row, joint in enumerate(dofs[1]):
        for column in range(num_forces):
            unactuated[row, column] = contact[column, joint]
        for place, dof in enumerate(dofs[0]):
            unactuated[row, num_forces + place] = -mass[joint, dof]
        unactuated[row, num_forces + len(dofs[0])] = -bias[joint]
        for place, dof in enumerate(dofs[1]):
            mass_uu[row, place] = mass[joint, dof]
    _solve(mass_uu, unactuated)


@part
def _solve(square: np.ndarray, right: np.ndarray) -> None:
    """Solve for the columns of ``right``; in place, by the upper triangle of L D Lᵀ."""
    size = len(square)
    for pivot in range(size):
        for row in range(pivot + 1, size):
            factor = square[pivot, row] / square[pivot, pivot]
            for column in range(row, size):
                square[row, column] -= factor * square[pivot, column]
            for column in range(right.shape[1]):
                right[row, column] -= factor * right[pivot, column]
    for row in range(size - 1, -1, -1):
        for other in range(row + 1, size):
            for column in range(right.shape[1]):
                right[row, column] -= square[row, other] * right[other, column]
        for column in range(right.shape[1]):
            right[row, column] /= square[row, row]
