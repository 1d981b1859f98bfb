"""Dynamics of the controller's own, nominal model of the robot: MuJoCo's terms."""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

from dataclasses import dataclass

import numpy as np

from slider.config.robot import RobotConfig
from slider.control.whole_body.copies import Copies, Terms
from slider.robot import names
from slider.robot.mjcf import SimulationOptions, build_model, nominal_qpos

NUM_DOFS = 6 + names.NUM_JOINTS
_BASE_BODY = 1
_FLOATING, _BASE_TURN = slice(0, 6), slice(3, 6)
_LEGS = slice(6, 11), slice(12, 17)  # without the upper feet, which move no sole


@dataclass(frozen=True)
class Dynamics:
    """Terms of M q̈ + h = Sᵀτ + Jᵀf for n robots, and where their parts are.

    Attributes:
        base_position: (n, 3) [m].
        joints: positions (n, 12) [rad, m].
        qvel: (n, 18).
        mass_matrix: M (n, 18, 18).
        bias: h (n, 18), Coriolis, gravity and joint damping.
        com, com_velocity: centre of mass (n, 3) [m], [m/s].
        com_jacobian: (n, 3, 18).
        com_bias: its acceleration at q̈ = 0 (n, 3) [m/s²].
        base_rotation: (n, 3, 3) to world; base_quaternion: (n, 4).
        foot_positions: middle of the foot lines (n, 2, 3) [m].
        foot_rotations: (n, 2, 3, 3) to world.
        foot_jacobians: of these points, linear above angular (n, 2, 6, 18).
        foot_bias: their accelerations at q̈ = 0 (n, 2, 6).
    """

    base_position: np.ndarray
    joints: np.ndarray
    qvel: np.ndarray
    mass_matrix: np.ndarray
    bias: np.ndarray
    com: np.ndarray
    com_velocity: np.ndarray
    com_jacobian: np.ndarray
    com_bias: np.ndarray
    base_rotation: np.ndarray
    base_quaternion: np.ndarray
    foot_positions: np.ndarray
    foot_rotations: np.ndarray
    foot_jacobians: np.ndarray
    foot_bias: np.ndarray

    def of(self, index: np.ndarray) -> "Dynamics":
        """The terms of some of the robots, in their order."""
        if len(index) == len(self.qvel) and index.dtype != bool:
            return self  # all of them
        return Dynamics(*(getattr(self, name)[index] for name in self.__dataclass_fields__))


class NominalModel:
    """Evaluates the nominal model, without the plant's perturbations and contacts."""

    def __init__(self, robot: RobotConfig) -> None:
        self.model = build_model(robot, SimulationOptions(actuation="torque"))
        self.mass = float(self.model.body_subtreemass[_BASE_BODY])
        self._copies = Copies(robot)
        self._damping = self.model.dof_damping.reshape(NUM_DOFS, -1)[:, 0].copy()
        self.nominal_height = self._standing_com_height(robot)

    def _standing_com_height(self, robot: RobotConfig) -> float:
        """Height of the centre of mass above the soles in the nominal pose [m]."""
        qpos = nominal_qpos(robot)[None]
        return float(self.evaluate(qpos, np.zeros((1, NUM_DOFS))).com[0, 2])

    def evaluate(self, qpos: np.ndarray, qvel: np.ndarray) -> Dynamics:
        """Terms at positions (n, 19) and velocities (n, 18)."""
        terms = self._copies.evaluate(qpos, qvel)
        mass, bias = terms.mass_matrix, terms.bias
        com_jacobian = mass[:, :3] / self.mass  # momentum = mass × velocity of the centre of mass
        com_bias = bias[:, :3] / self.mass - [0.0, 0.0, names.GRAVITY]
        jacobians, rates = _foot_jacobians(terms)
        return Dynamics(
            base_position=qpos[:, :3],
            joints=qpos[:, 7:],
            qvel=qvel,
            mass_matrix=mass,
            bias=bias + self._damping * qvel,
            com=terms.com,
            com_velocity=np.einsum("nij,nj->ni", com_jacobian, qvel),
            com_jacobian=com_jacobian,
            com_bias=com_bias,
            base_rotation=terms.base_rotation,
            base_quaternion=qpos[:, 3:7],
            foot_positions=terms.soles,
            foot_rotations=terms.sole_rotations,
            foot_jacobians=jacobians,
            foot_bias=(rates @ qvel[:, None, :, None])[..., 0],
        )


def _foot_jacobians(terms: Terms) -> tuple[np.ndarray, np.ndarray]:
    """Of the soles, linear above angular, and their derivatives (n, 2, 6, 18); as ``mj_jac``."""
    n = len(terms.com)
    jacobians, rates = np.zeros((2, n, 2, 6, NUM_DOFS))
    turn, move = terms.axes[:3], terms.axes[3:]
    turn_rate, move_rate = _axis_rates(terms)
    offsets = (terms.soles - terms.com[:, None]).T  # (3, 2, n)
    for leg, own in enumerate(_LEGS):
        offset, twist = offsets[:, leg], terms.twists[:, 1 + leg]
        speed = [twist[3 + k] - _cross(offset, twist[:3], k) for k in range(3)]
        for dofs in (_FLOATING, own):
            axis, rate = turn[:, dofs], turn_rate[:, dofs]
            for k in range(3):
                linear = move[k, dofs] + _cross(axis, offset, k)
                jacobians[:, leg, k, dofs], jacobians[:, leg, 3 + k, dofs] = linear.T, axis[k].T
                linear = move_rate[k, dofs] + _cross(rate, offset, k) + _cross(axis, speed, k)
                rates[:, leg, k, dofs], rates[:, leg, 3 + k, dofs] = linear.T, rate[k].T
    return jacobians, rates


def _axis_rates(terms: Terms) -> tuple[np.ndarray, np.ndarray]:
    """Angular and linear part (3, 18, n); those of the base's rotation turn with the base."""
    axes, rates, twist = terms.axes[:, _BASE_TURN], terms.axis_rates.copy(), terms.twists[:, 0]
    for k in range(3):
        rates[k, _BASE_TURN] = _cross(twist[:3], axes[:3], k)
        moved = _cross(twist[:3], axes[3:], k) + _cross(twist[3:], axes[:3], k)
        rates[3 + k, _BASE_TURN] = moved
    return rates[:3], rates[3:]


def _cross(a: np.ndarray, b: np.ndarray | list[np.ndarray], k: int) -> np.ndarray:
    """Component ``k`` of a × b, of components first."""
    i, j = (k + 1) % 3, (k + 2) % 3
    return a[i] * b[j] - a[j] * b[i]
