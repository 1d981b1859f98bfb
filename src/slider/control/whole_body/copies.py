"""Many copies of the robot in one MuJoCo model: a call of its routines evaluates all of them.

A copy's numbers are to the bit those of a model of its own.
"""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

from dataclasses import dataclass

import mujoco
import numpy as np

from slider.config.robot import RobotConfig
from slider.robot import names
from slider.robot.mjcf import SimulationOptions, build_spec

_COPIES = 32


@dataclass(frozen=True)
class Terms:
    """MuJoCo's terms of n robots with d degrees of freedom.

    Attributes:
        mass_matrix: M (n, d, d), with the rotors of the tendons.
        bias: Coriolis and gravity forces (n, d).
        com: centre of mass (n, 3) [m].
        base_rotation: to world (n, 3, 3).
        soles, sole_rotations: middle of the foot lines (n, 2, 3) [m], (n, 2, 3, 3) to world.
        axes: motion of the feet's tree per rate, angular above linear, at ``com`` (6, d, n).
        axis_rates: their derivatives (6, d, n).
        twists: of base, left and right foot, angular above linear, at ``com`` (6, 3, n).
    """

    mass_matrix: np.ndarray
    bias: np.ndarray
    com: np.ndarray
    base_rotation: np.ndarray
    soles: np.ndarray
    sole_rotations: np.ndarray
    axes: np.ndarray
    axis_rates: np.ndarray
    twists: np.ndarray


class Copies:
    """Evaluates any number of robots, as many at once as the model has copies."""

    def __init__(self, robot: RobotConfig) -> None:
        self._model = model = _repeated(robot)
        self._data = data = mujoco.MjData(model)
        self._dofs = model.nv // _COPIES
        soles = [model.site(f"0_{names.sole(side)}").id for side in names.SIDES]
        bodies = [names.BASE, *(names.foot(side) for side in names.SIDES)]
        places = [model.body(f"0_{name}").id - 1 for name in bodies]
        self._places, self._soles = places, soles
        self._qpos, self._qvel = _per_copy(data.qpos), _per_copy(data.qvel)
        self._mass, self._bias = _per_copy(data.M), _per_copy(data.qfrc_bias)
        self._com = _per_copy(data.subtree_com[1:])
        self._rotations, self._twists = _per_copy(data.xmat[1:]), _per_copy(data.cvel[1:])
        self._sites, self._turns = _per_copy(data.site_xpos), _per_copy(data.site_xmat)
        self._axes, self._rates = _per_copy(data.cdof), _per_copy(data.cdof_dot)
        self._entries = self._dense_entries()

    def _dense_entries(self) -> np.ndarray:
        """Where the sparse M of a copy, with a zero after it, has each entry of the dense one."""
        model, size = self._model, self._mass.shape[1]
        entries = np.full((self._dofs, self._dofs), size)
        for row in range(self._dofs):
            start = model.M_rowadr[row]
            for place in range(start, start + model.M_rownnz[row]):
                column = model.M_colind[place]
                entries[row, column] = entries[column, row] = place
        return entries

    def evaluate(self, qpos: np.ndarray, qvel: np.ndarray) -> Terms:
        """Terms at positions (n, 19) and velocities (n, 18)."""
        n, d = qvel.shape
        mass, bias = np.zeros((n, self._mass.shape[1] + 1)), np.empty((n, d))
        com, rotation = np.empty((n, 3)), np.empty((n, 9))
        soles, turns = np.empty((n, 2, 3)), np.empty((n, 2, 9))
        axes, rates, twists = np.empty((6, d, n)), np.empty((6, d, n)), np.empty((6, 3, n))
        for start in range(0, n, _COPIES):
            some = slice(start, min(n, start + _COPIES))
            own = slice(0, some.stop - start)
            self._move(own, qpos[some], qvel[some])
            mass[some, :-1], bias[some] = self._mass[own], self._bias[own]
            com[some], rotation[some] = self._com[own, 0], self._rotations[own, 0]
            soles[some], turns[some] = self._sites[own, self._soles], self._turns[own, self._soles]
            axes[:, :, some], rates[:, :, some] = self._axes[own].T, self._rates[own].T
            twists[:, :, some] = self._twists[own, self._places].T
        return Terms(
            np.take(mass, self._entries, axis=1),
            bias,
            com,
            rotation.reshape(n, 3, 3),
            soles,
            turns.reshape(n, 2, 3, 3),
            axes,
            rates,
            twists,
        )

    def _move(self, copies: slice, qpos: np.ndarray, qvel: np.ndarray) -> None:
        model, data = self._model, self._data
        self._qpos[copies], self._qvel[copies] = qpos, qvel
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_tendon(model, data)
        mujoco.mj_makeM(model, data)  # with the capstan rotors' inertia
        mujoco.mj_comVel(model, data)
        mujoco.mj_rne(model, data, 0, data.qfrc_bias)


def _repeated(robot: RobotConfig) -> mujoco.MjModel:
    """Copies of the robot in an empty world, their names with a number before them."""
    spec = mujoco.MjSpec()
    for number in range(_COPIES):
        one = build_spec(robot, SimulationOptions(actuation="torque"))
        spec.option = one.option
        spec.worldbody.add_frame().attach_body(one.body(names.BASE), f"{number}_", "")
    return spec.compile()


def _per_copy(values: np.ndarray) -> np.ndarray:
    """A view (copies, …) of a model's values, row by row or one after the other."""
    return values.reshape(_COPIES, -1, *values.shape[1:])
