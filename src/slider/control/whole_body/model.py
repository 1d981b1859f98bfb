"""Dynamics of the controller's nominal model of the robot: MuJoCo's terms.

Many copies of the robot stand in one MuJoCo model, so that a call of its routines evaluates all of
them. The terms of a copy equal those of a model with one robot to the bit.
"""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

from dataclasses import dataclass

import mujoco
import numpy as np

from slider.config.robot import RobotConfig
from slider.core.arrays import consecutive, take
from slider.core.compiled import compiled, part
from slider.robot import names
from slider.robot.mjcf import SimulationOptions, build_model, build_spec, nominal_qpos

NUM_DOFS = 6 + names.NUM_JOINTS
_COPIES = 32
_BASE_BODY = 1
_FLOATING, _BASE_TURN = 6, 3  # degrees of freedom of the base; from here on they are its rotation


@dataclass(frozen=True)
class Dynamics:
    """Terms of M q̈ + h = Sᵀτ + Jᵀf for n robots, and positions of their parts.

    Attributes:
        base_position: (n, 3) [m].
        joints: positions (n, 12) [rad, m].
        qvel: (n, 18).
        mass_matrix: M (n, 18, 18).
        bias: h (n, 18), Coriolis, gravity and joint damping.
        com, com_velocity: centre of mass (n, 3) [m], [m/s].
        com_jacobian: (n, 3, 18).
        com_bias: its acceleration at q̈ = 0 (n, 3) [m/s²].
        base_rotation: (n, 3, 3) to world.
        foot_positions: of the soles, below the ankles (n, 2, 3) [m].
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
    foot_positions: np.ndarray
    foot_rotations: np.ndarray
    foot_jacobians: np.ndarray
    foot_bias: np.ndarray

    def take(self, index: np.ndarray) -> "Dynamics":
        """The terms of some of the robots, with increasing indices (n,)."""
        return take(self, consecutive(index))


class NominalModel:
    """Evaluates the nominal model, without the plant's perturbations and contacts.

    Attributes:
        model: of one robot.
        mass: of the robot [kg].
        nominal_height: of the centre of mass above the soles in the nominal pose [m].
    """

    def __init__(self, robot: RobotConfig) -> None:
        self.model = build_model(robot, SimulationOptions(actuation="torque"))
        self.mass = float(self.model.body_subtreemass[_BASE_BODY])
        self._damping = self.model.dof_damping.reshape(NUM_DOFS, -1)[:, 0].copy()
        spec = mujoco.MjSpec()  # an empty world; names of the copies get their number as prefix
        for number in range(_COPIES):
            single = build_spec(robot, SimulationOptions(actuation="torque"))
            spec.option = single.option
            spec.worldbody.add_frame().attach_body(single.body(names.BASE), f"{number}_", "")
        self._copies = copies = spec.compile()
        self._data = data = mujoco.MjData(copies)
        self._qpos, self._qvel = _per_copy(data.qpos), _per_copy(data.qvel)
        # M, as its sparse entries, bias forces, centres of mass, rotations and sites, and about the
        # centre of mass, angular above linear, velocities of bodies, axes of degrees of freedom and
        # their derivatives.
        self._terms = tuple(
            _per_copy(values)
            for values in (
                *(data.M, data.qfrc_bias, data.subtree_com[1:], data.xmat[1:]),
                *(data.site_xpos, data.site_xmat, data.cvel[1:], data.cdof, data.cdof_dot),
            )
        )
        rows = np.repeat(np.arange(copies.nv), copies.M_rownnz)
        first = slice(self._terms[0].shape[1])
        self._entries = rows[first].copy(), copies.M_colind[first].astype(int)
        bodies = names.BASE, *(names.foot(side) for side in names.SIDES)
        self._places = (
            np.array([copies.site(f"0_{names.sole(side)}").id for side in names.SIDES]),
            np.array([copies.body(f"0_{name}").id - 1 for name in bodies]),
            # Without upper feet, which do not move the soles.
            _FLOATING + np.reshape(names.driven_joints(robot.geometry), (2, -1)),
        )
        standing = self.evaluate(nominal_qpos(robot)[None], np.zeros((1, NUM_DOFS)))
        self.nominal_height = float(standing.com[0, 2])

    def evaluate(self, qpos: np.ndarray, qvel: np.ndarray) -> Dynamics:
        """Terms at positions (n, 19) and velocities (n, 18)."""
        n, model, data = len(qvel), self._copies, self._data
        qvel = np.ascontiguousarray(qvel)
        mass, bias = np.empty((n, NUM_DOFS, NUM_DOFS)), np.empty((n, NUM_DOFS))
        com, turn = np.empty((n, 3)), np.empty((n, 9))
        soles, turns = np.empty((n, 2, 3)), np.empty((n, 2, 9))
        jacobians, rates = np.empty((n, 2, 6, NUM_DOFS)), np.empty((n, 2, 6))
        results = mass, bias, com, turn, soles, turns, jacobians, rates
        for start in range(0, n, _COPIES):  # unused copies keep terms of earlier robots
            count = min(_COPIES, n - start)
            self._qpos[:count] = qpos[start : start + count]
            self._qvel[:count] = qvel[start : start + count]
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_tendon(model, data)
            mujoco.mj_makeM(model, data)  # with the capstan rotors' inertia
            mujoco.mj_comVel(model, data)
            mujoco.mj_rne(model, data, 0, data.qfrc_bias)
            _read(self._terms, self._entries, self._places, start, qvel, results)
        com_jacobian = mass[:, :3] / self.mass  # momentum = mass × velocity of the centre of mass
        return Dynamics(
            base_position=qpos[:, :3],
            joints=qpos[:, 7:],
            qvel=qvel,
            mass_matrix=mass,
            bias=bias + self._damping * qvel,
            com=com,
            com_velocity=np.einsum("nij,nj->ni", com_jacobian, qvel),
            com_jacobian=com_jacobian,
            com_bias=bias[:, :3] / self.mass - [0.0, 0.0, names.GRAVITY],
            base_rotation=turn.reshape(n, 3, 3),
            foot_positions=soles,
            foot_rotations=turns.reshape(n, 2, 3, 3),
            foot_jacobians=jacobians,
            foot_bias=rates,
        )


def _per_copy(values: np.ndarray) -> np.ndarray:
    """A view (copies, …) of a model's values, row by row or one after the other."""
    return values.reshape(_COPIES, -1, *values.shape[1:])


_Arrays = tuple[np.ndarray, ...]


@compiled
def _read(
    terms: _Arrays,
    entries: _Arrays,
    places: _Arrays,
    start: int,
    qvel: np.ndarray,
    results: _Arrays,
) -> None:
    """Read the terms of the robots from ``start`` on, at most as many as there are copies."""
    sparse, forces, coms, rotations, sites, site_rotations, twists, axes, rates = terms
    mass, bias, com, rotation, soles, sole_rotations, jacobians, foot_bias = results
    (rows, columns), (own_sites, bodies, legs) = entries, places
    offset, speed = np.empty(3), np.empty(3)
    for copy in range(min(len(sparse), len(qvel) - start)):
        robot = start + copy
        mass[robot] = 0.0
        for place, value in enumerate(sparse[copy]):
            row, column = rows[place], columns[place]
            mass[robot, row, column] = mass[robot, column, row] = value
        _copy(bias[robot], forces[copy])
        _copy(com[robot], coms[copy, 0])
        _copy(rotation[robot], rotations[copy, 0])
        _turn_with_base(axes[copy], twists[copy, bodies[0]], rates[copy])
        for leg, site in enumerate(own_sites):
            _copy(soles[robot, leg], sites[copy, site])
            _copy(sole_rotations[robot, leg], site_rotations[copy, site])
            twist = twists[copy, bodies[1 + leg]]
            for k in range(3):
                offset[k] = sites[copy, site, k] - com[robot, k]
            for k in range(3):
                speed[k] = twist[3 + k] - _cross(offset, twist[:3], k)
            jacobian, rate = jacobians[robot, leg], foot_bias[robot, leg]
            jacobian[:] = 0.0
            rate[:] = 0.0
            for place in range(_FLOATING + legs.shape[1]):
                dof = place if place < _FLOATING else legs[leg, place - _FLOATING]
                motion = axes[copy, dof], rates[copy, dof], qvel[robot, dof]
                _add_motion(motion, offset, speed, jacobian[:, dof], rate)


@part
def _copy(target: np.ndarray, source: np.ndarray) -> None:
    for k in range(len(source)):  # an assignment of slices takes a second to compile
        target[k] = source[k]


@part
def _turn_with_base(axes: np.ndarray, twist: np.ndarray, rates: np.ndarray) -> None:
    """Derivatives of the axes (d, 6) of the base's rotation, which turn with it."""
    for dof in range(_BASE_TURN, _FLOATING):
        turn, move = axes[dof, :3], axes[dof, 3:]
        for k in range(3):
            rates[dof, k] = _cross(twist[:3], turn, k)
            rates[dof, 3 + k] = _cross(twist[:3], move, k) + _cross(twist[3:], turn, k)


@part
def _add_motion(
    motion: tuple[np.ndarray, np.ndarray, float],
    offset: np.ndarray,
    speed: np.ndarray,
    column: np.ndarray,
    bias: np.ndarray,
) -> None:
    """A degree of freedom's Jacobian column for a sole, as ``mj_jac``, and part of the bias."""
    (axis, rate, velocity), turn, turn_rate = motion, motion[0][:3], motion[1][:3]
    for k in range(3):
        column[k], column[3 + k] = axis[3 + k] + _cross(turn, offset, k), turn[k]
        linear = rate[3 + k] + _cross(turn_rate, offset, k) + _cross(turn, speed, k)
        bias[k] += linear * velocity
        bias[3 + k] += turn_rate[k] * velocity


@part
def _cross(a: np.ndarray, b: np.ndarray, k: int) -> float:
    """Component ``k`` of a × b."""
    i, j = (k + 1) % 3, (k + 2) % 3
    return a[i] * b[j] - a[j] * b[i]
