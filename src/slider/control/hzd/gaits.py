"""What the controller needs of the gaits, blended for the commands of many robots at once.

Everything is in the frame of the stance foot, reflected in right stance, so that left and right
steps have the same form.
"""

from dataclasses import dataclass

import numpy as np

from slider.control.whole_body.nominal import Dynamics, NominalModel
from slider.control.whole_body.tasks import pitch_and_yaw
from slider.hzd.outputs import LEG, NUM_JOINTS
from slider.hzd.polynomials import NodeTable
from slider.library.mesh import VelocityMesh
from slider.library.reader import GaitLibrary
from slider.robot.names import ACTUATED, LEG_MIRROR_SIGN, SIDES
from slider.robot.names import NUM_JOINTS as ALL_JOINTS

_DRIVEN = np.array(ACTUATED)
_STEPS = len(SIDES)
_PLACE = 2  # forward, left


@dataclass(frozen=True)
class Steps:
    """Steps of n robots.

    Attributes:
        duration: (n,) [s].
        coefficients: (n, 10, degree + 1) Bézier coefficients of the virtual legs [rad].
        roll: of the stance foot's line (m = 1) [rad].
        hip: forward place of the hip over the stance foot (m = 1) [m].
        com: place of the centre of mass over the stance foot, forward and left (m = 2) [m].
        placement: joints (n, 10, 2) that displace the swing foot.
    """

    duration: np.ndarray
    coefficients: np.ndarray
    roll: NodeTable
    hip: NodeTable
    com: NodeTable
    placement: np.ndarray


class GaitTables:
    """All gaits of a library.

    Args:
        library: the gaits.
        model: of the robot that walks them.
    """

    def __init__(self, library: GaitLibrary, model: NominalModel) -> None:
        self.mesh: VelocityMesh = library.mesh
        self._count, samples = library.samples.shape[:2]
        self._nodes = samples // _STEPS
        self._times = library.step_time
        parts = [library.arrays["coefficients"], self._roll(library), *self._places(library, model)]
        self._shapes = [part.shape[2:] for part in parts]
        flat = [part.reshape(self._count, _STEPS, -1) for part in parts]
        self._ends = np.cumsum([part.shape[2] for part in flat])
        self._table = np.concatenate(flat, axis=2).swapaxes(0, 1)  # (2, G, values)

    def at(self, velocity: np.ndarray, stance: np.ndarray) -> Steps:
        """Steps on the feet ``stance`` (n,) at velocities (n, 2) [m/s]."""
        weights = self.mesh.weights(*velocity.T)
        values, times = np.zeros((len(stance), self._table.shape[2])), np.zeros(len(stance))
        for side in range(_STEPS):
            own = stance == side
            values[own] = weights[own] @ self._table[side]
            times[own] = weights[own] @ self._times[:, side]
        split = np.split(values, self._ends[:-1], axis=1)
        parts = [v.reshape(len(stance), *s) for v, s in zip(split, self._shapes, strict=True)]
        coefficients, roll, com, hip, placement = parts
        return Steps(
            times,
            coefficients,
            NodeTable(*(roll[:, :, k, None] for k in range(3))),
            NodeTable(hip[:, :, :1], hip[:, :, 1:]),
            NodeTable(com[:, :, :_PLACE], com[:, :, _PLACE:]),
            placement,
        )

    def _roll(self, library: GaitLibrary) -> np.ndarray:
        """Roll and its derivatives over the phase (G, 2, nodes, 3)."""
        times = self._times[:, :, None, None]
        return library.arrays["roll"] * np.concatenate([times**k for k in range(3)], axis=3)

    def _places(
        self, library: GaitLibrary, model: NominalModel
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Centre of mass (…, 4), hip (…, 2) at the nodes, with slopes, and placement (…, 10, 2)."""
        base, joints = library.base.reshape(-1, 13), library.samples.reshape(-1, 26)
        qpos = np.concatenate([base[:, :7], joints[:, :ALL_JOINTS]], axis=1)
        qvel = np.concatenate([base[:, 7:], joints[:, ALL_JOINTS : 2 * ALL_JOINTS]], axis=1)
        dynamics = model.evaluate(qpos, qvel)
        rows = np.arange(len(qpos))
        stance = np.tile(np.repeat(np.arange(_STEPS), self._nodes), self._count)
        sole = dynamics.foot_positions[rows, stance, :_PLACE]
        mirror = np.stack([np.ones(len(rows)), np.where(stance == 0, 1.0, -1.0)], axis=1)
        duration = self._times[:, :, None].repeat(self._nodes, axis=2).reshape(-1, 1)
        com = mirror * (dynamics.com[:, :_PLACE] - sole)
        speed = mirror * dynamics.com_velocity[:, :_PLACE] * duration
        hip = np.stack([qpos[:, 0] - sole[:, 0], qvel[:, 0] * duration[:, 0]], axis=1)
        shape = (self._count, _STEPS, self._nodes, -1)
        ends = np.flatnonzero(np.arange(len(rows)) % self._nodes == self._nodes - 1)
        placement = self._placement(dynamics.of(ends), 1 - stance[ends])
        return (
            np.concatenate([com, speed], axis=1).reshape(shape),
            hip.reshape(shape),
            placement.reshape(self._count, _STEPS, NUM_JOINTS, _PLACE),
        )

    @staticmethod
    def _placement(dynamics: Dynamics, foot: np.ndarray) -> np.ndarray:
        """Swing joints (n, 10, 2) per metre; the foot keeps height, pitch and yaw."""
        rows = np.arange(len(foot))
        jacobian = dynamics.foot_jacobians[rows, foot]
        axes = pitch_and_yaw(dynamics.foot_rotations[rows, foot])
        task = np.concatenate([jacobian[:, :3], axes @ jacobian[:, 3:]], axis=1)
        columns = 6 + _DRIVEN.reshape(_STEPS, LEG)[foot]
        square = np.take_along_axis(task, columns[:, None, :], axis=2)
        unit = np.broadcast_to(np.eye(LEG)[:, :_PLACE], (len(foot), LEG, _PLACE))
        found = np.zeros((len(foot), NUM_JOINTS, _PLACE))
        found[:, LEG:] = np.linalg.solve(square, unit)
        # In right stance the left foot swings: reflected, joints and the displacement to the left.
        sign = np.array(LEG_MIRROR_SIGN[:LEG])[:, None] * np.array([1.0, -1.0])
        found[foot == 0, LEG:] *= sign
        return found
