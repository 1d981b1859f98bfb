"""Dynamics of the controller's own, nominal model of the robot: MuJoCo's terms."""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

from dataclasses import dataclass

import mujoco
import numpy as np

from slider.config.robot import RobotConfig
from slider.robot import names
from slider.robot.mjcf import SimulationOptions, build_model, nominal_qpos

NUM_DOFS = 6 + names.NUM_JOINTS
_BASE_BODY = 1


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
        """The terms of some of the robots."""
        return Dynamics(*(getattr(self, name)[index] for name in self.__dataclass_fields__))


class NominalModel:
    """Evaluates the nominal model, without the plant's perturbations and contacts."""

    def __init__(self, robot: RobotConfig) -> None:
        self.model = build_model(robot, SimulationOptions(actuation="torque"))
        self.mass = float(self.model.body_subtreemass[_BASE_BODY])
        self._data = mujoco.MjData(self.model)
        self._damping = self.model.dof_damping.reshape(NUM_DOFS, -1)[:, 0].copy()
        self._feet = [self.model.body(names.foot(side)).id for side in names.SIDES]
        self._soles = [self.model.site(names.sole(side)).id for side in names.SIDES]
        self.nominal_height = self._standing_com_height(robot)

    def _standing_com_height(self, robot: RobotConfig) -> float:
        """Height of the centre of mass above the soles in the nominal pose [m]."""
        qpos = nominal_qpos(robot)[None]
        return float(self.evaluate(qpos, np.zeros((1, NUM_DOFS))).com[0, 2])

    def evaluate(self, qpos: np.ndarray, qvel: np.ndarray) -> Dynamics:
        """Terms at positions (n, 19) and velocities (n, 18)."""
        n = len(qpos)
        mass, bias = np.zeros((n, NUM_DOFS, NUM_DOFS)), np.empty((n, NUM_DOFS))
        com, rotation = np.empty((n, 3)), np.empty((n, 9))
        feet, turns = np.empty((n, 2, 3)), np.empty((n, 2, 9))
        jacobians, rates = np.empty((n, 2, 6, NUM_DOFS)), np.empty((n, 2, 6, NUM_DOFS))
        data = self._data
        for i in range(n):
            self._move(qpos[i], qvel[i])
            mujoco.mj_fullM(self.model, data, mass[i])
            bias[i] = data.qfrc_bias
            com[i], rotation[i] = data.subtree_com[_BASE_BODY], data.xmat[_BASE_BODY]
            feet[i], turns[i] = data.site_xpos[self._soles], data.site_xmat[self._soles]
            self._differentiate(jacobians[i], rates[i], feet[i])
        com_jacobian = mass[:, :3] / self.mass  # momentum = mass × velocity of the centre of mass
        com_bias = bias[:, :3] / self.mass - [0.0, 0.0, names.GRAVITY]
        return Dynamics(
            base_position=qpos[:, :3],
            joints=qpos[:, 7:],
            qvel=qvel,
            mass_matrix=mass,
            bias=bias + self._damping * qvel,
            com=com,
            com_velocity=np.einsum("nij,nj->ni", com_jacobian, qvel),
            com_jacobian=com_jacobian,
            com_bias=com_bias,
            base_rotation=rotation.reshape(n, 3, 3),
            base_quaternion=qpos[:, 3:7],
            foot_positions=feet,
            foot_rotations=turns.reshape(n, 2, 3, 3),
            foot_jacobians=jacobians,
            foot_bias=(rates @ qvel[:, None, :, None])[..., 0],
        )

    def _move(self, qpos: np.ndarray, qvel: np.ndarray) -> None:
        model, data = self.model, self._data
        data.qpos[:] = qpos
        data.qvel[:] = qvel
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_tendon(model, data)
        mujoco.mj_makeM(model, data)  # with the capstan rotors' inertia
        mujoco.mj_comVel(model, data)
        mujoco.mj_rne(model, data, 0, data.qfrc_bias)

    def _differentiate(self, jacobian: np.ndarray, rate: np.ndarray, points: np.ndarray) -> None:
        for leg, body in enumerate(self._feet):
            upper, lower = jacobian[leg, :3], jacobian[leg, 3:]
            mujoco.mj_jac(self.model, self._data, upper, lower, points[leg], body)
            upper, lower = rate[leg, :3], rate[leg, 3:]
            mujoco.mj_jacDot(self.model, self._data, upper, lower, points[leg], body)
