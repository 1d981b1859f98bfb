"""Many copies of the robot in one MuJoCo model: a call of its routines evaluates all of them.

A copy's numbers are to the bit those of a model of its own.
"""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

from collections.abc import Iterator

import mujoco
import numpy as np

from slider.config.robot import RobotConfig
from slider.robot import names
from slider.robot.mjcf import SimulationOptions, build_spec

_COPIES = 32


class Copies:
    """Evaluates any number of robots, as many at once as the model has copies.

    Attributes:
        terms: MuJoCo's arrays (copies, …) of the last evaluation: M, as its sparse entries, bias
            forces, centres of mass, rotations and sites, and about the centre of mass, angular
            above linear, velocities of bodies, axes of degrees of freedom and their derivatives.
        entries: rows (r,), columns (r,) of the sparse M.
        soles, bodies: places of the soles among the sites; of base and feet among the bodies.
    """

    def __init__(self, robot: RobotConfig) -> None:
        self._model = model = _repeated(robot)
        self._data = data = mujoco.MjData(model)
        self._qpos, self._qvel = _per_copy(data.qpos), _per_copy(data.qvel)
        self.terms = tuple(
            _per_copy(values)
            for values in (
                *(data.M, data.qfrc_bias, data.subtree_com[1:], data.xmat[1:]),
                *(data.site_xpos, data.site_xmat, data.cvel[1:], data.cdof, data.cdof_dot),
            )
        )
        rows = np.repeat(np.arange(model.nv), model.M_rownnz)
        one = slice(self.terms[0].shape[1])
        self.entries = rows[one].copy(), model.M_colind[one].astype(int)
        self.soles = np.array([model.site(f"0_{names.sole(side)}").id for side in names.SIDES])
        bodies = names.BASE, *(names.foot(side) for side in names.SIDES)
        self.bodies = np.array([model.body(f"0_{name}").id - 1 for name in bodies])

    def evaluate(self, qpos: np.ndarray, qvel: np.ndarray) -> Iterator[int]:
        """Evaluate positions (n, 19) and velocities (n, 18); the first robot of each of the calls.

        The copies that are left over in the last call have terms of robots before.
        """
        for start in range(0, len(qvel), _COPIES):
            some = slice(start, start + _COPIES)
            self._move(slice(len(qvel[some])), qpos[some], qvel[some])
            yield start

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
