"""What the controller needs of the gaits, blended for the commands of many robots at once.

Everything is in the frame of the stance foot, reflected in right stance, so that left and right
steps have the same form.
"""

from dataclasses import dataclass

import numpy as np

from slider.core.errors import UserError
from slider.hzd.gains import FootPlacement
from slider.hzd.polynomials import NodeTable
from slider.library.mesh import CommandMesh
from slider.library.reader import GaitLibrary
from slider.robot.names import SIDES

_STEPS = len(SIDES)


@dataclass(frozen=True)
class Steps:
    """Steps of n robots; S phases.

    Attributes:
        duration: (n,) [s].
        coefficients: (n, 10, degree + 1) Bézier coefficients of the virtual legs [rad].
        roll: of the stance foot's line (m = 1) [rad].
        hip: forward place of the hip over the stance foot (m = 1) [m].
        gains, orbit: K (n, S, 2, 3) and ξ* (n, S, 3) of :class:`FootPlacement`.
        placement: joints (n, 10, 2) that displace the swing foot.
    """

    duration: np.ndarray
    coefficients: np.ndarray
    roll: NodeTable
    hip: NodeTable
    gains: np.ndarray
    orbit: np.ndarray
    placement: np.ndarray


class GaitTables:
    """All gaits of a library with their foot placement.

    Raises:
        UserError: the two are not of the same gaits.
    """

    def __init__(self, library: GaitLibrary, feedback: FootPlacement) -> None:
        if not np.array_equal(library.commands, feedback.commands):
            found = f"found one of {len(feedback.commands)} others"
            raise UserError(f"expected the foot placement of {len(library)} gaits, {found}")
        self.mesh: CommandMesh = library.mesh
        time = library.step_time[:, :, None, None]
        roll = library.arrays["roll"] * np.concatenate([time**k for k in range(3)], axis=3)
        parts = [library.step_time, library.arrays["coefficients"], roll, feedback.hip]
        parts += [feedback.gains, feedback.orbit, feedback.placement]
        self._shapes = [part.shape[2:] for part in parts]
        flat = [part.reshape(len(library), _STEPS, -1) for part in parts]
        self._ends = np.cumsum([part.shape[2] for part in flat])
        self._table = np.concatenate(flat, axis=2).swapaxes(0, 1)  # (2, G, values)

    def at(self, command: np.ndarray, stance: np.ndarray) -> Steps:
        """Steps on the feet ``stance`` (n,) at commands (n, 3); each as if it were alone."""
        values = np.empty((len(stance), self._table.shape[2]))
        for row, weights in enumerate(self.mesh.weights(command)):
            near = np.flatnonzero(weights)
            values[row] = weights[near] @ self._table[stance[row], near]
        split = np.split(values, self._ends[:-1], axis=1)
        parts = [v.reshape(len(stance), *s) for v, s in zip(split, self._shapes, strict=True)]
        times, coefficients, roll, hip, gains, orbit, placement = parts
        return Steps(times, coefficients, _table(roll), _table(hip), gains, orbit, placement)


def _table(orders: np.ndarray) -> NodeTable:
    """Of values with two derivatives (n, nodes, 3)."""
    return NodeTable(*(orders[:, :, k, None] for k in range(3)))


def at_phase(table: np.ndarray, phase: np.ndarray) -> np.ndarray:
    """Rows (n, …) of a table (n, S, …) over equally spaced phases, linearly; the ends hold."""
    place = np.clip(phase, 0.0, 1.0) * (table.shape[1] - 1)
    left = np.minimum(place.astype(int), table.shape[1] - 2)
    rows = np.arange(len(phase))
    share = (place - left).reshape(-1, *(1,) * (table.ndim - 2))
    return table[rows, left] + share * (table[rows, left + 1] - table[rows, left])
