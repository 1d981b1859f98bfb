"""Variables of a walk, and constant matrices from them to nodes and step ends.

Variables of a step: joint variables, step time, and roll, roll rate and roll acceleration of the
stance foot at every node. The joints' motion over a step is linear in its variables, in two ways.
``bezier``: virtual constraints, polynomials of the phase. ``collocation``: positions, velocities
and accelerations of all joints at every node, tied by Hermite-Simpson defects.
"""

from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from slider.config.gait import FormulationConfig
from slider.gait import bezier
from slider.gait.motion import NodeSymbols
from slider.gait.tree import NUM_JOINTS

ORDERS = 3  # positions and their first and second derivatives with respect to the phase
# Of collocated variables: brings derivatives over the phase near one.
_SCALES = (1.0, 10.0, 100.0)
NODE = NodeSymbols.SIZE
END = 2 + 2 * NUM_JOINTS  # roll, roll rate, joints, joint rates over normalised time
STEP = 2 * END + 1  # start, end, step time
ROLL_STATES = 3


@dataclass(frozen=True)
class Transcription:
    """Joint variables of one step.

    Attributes:
        size: number of variables.
        nodes: (3 · nodes · 10, size) to the orders, nodes and joints, in this nesting.
        defects: (rows, size), zero for a valid motion.
        bounded: (size,) the joint whose position a variable is (or bounds), −1 for others.
    """

    size: int
    nodes: np.ndarray
    defects: np.ndarray
    bounded: np.ndarray


def bezier_joints(nodes: int, degree: int) -> Transcription:
    """Coefficients of the ten joints, joint by joint."""
    phase, width = np.linspace(0.0, 1.0, nodes), degree + 1
    size = NUM_JOINTS * width
    blocks = [_interleave(bezier.basis_derivative(degree, phase, order)) for order in range(ORDERS)]
    joints = np.repeat(np.arange(NUM_JOINTS), width)  # a polynomial stays in its coefficients' hull
    return Transcription(size, np.concatenate(blocks), np.zeros((0, size)), joints)


def _interleave(basis: np.ndarray) -> np.ndarray:
    """(nodes · 10, 10 · width) from a basis (nodes, width)."""
    return np.einsum("kw,ij->kijw", basis, np.eye(NUM_JOINTS)).reshape(
        len(basis) * NUM_JOINTS, NUM_JOINTS * basis.shape[1]
    )


def collocated_joints(nodes: int) -> Transcription:
    """Values of the three orders at every node, node by node."""
    width = ORDERS * NUM_JOINTS
    eye = np.eye(nodes * width)
    place = np.arange(nodes * width).reshape(nodes, ORDERS, NUM_JOINTS)
    orders = [eye[place[:, order].ravel()] * _SCALES[order] for order in range(ORDERS)]
    joints = np.full((nodes, ORDERS, NUM_JOINTS), -1)
    joints[:, 0] = np.arange(NUM_JOINTS)
    defects = [_defects(orders[order], orders[order + 1], nodes) for order in range(ORDERS - 1)]
    return Transcription(
        nodes * width, np.concatenate(orders), np.concatenate(defects), joints.ravel()
    )


def _defects(value: np.ndarray, slope: np.ndarray, nodes: int) -> np.ndarray:
    """Hermite-Simpson rows, separated form, of a quantity and its derivative."""
    interval = 2.0 / (nodes - 1)
    rows = np.arange(nodes * NUM_JOINTS).reshape(nodes, NUM_JOINTS)
    a, m, b = (rows[start : nodes - 2 + start : 2].ravel() for start in range(3))
    middle = value[m] - (value[a] + value[b]) / 2 - interval / 8 * (slope[a] - slope[b])
    end = value[b] - value[a] - interval / 6 * (slope[a] + 4 * slope[m] + slope[b])
    return np.concatenate([middle, end])


def from_polynomials(transcription: Transcription, coefficients: np.ndarray) -> np.ndarray:
    """Variables (size,) of Bézier polynomials (10, degree + 1); exact where they are the same."""
    if transcription.size == coefficients.size and transcription.defects.shape[0] == 0:
        return coefficients.ravel()
    per_order = transcription.nodes.shape[0] // ORDERS // NUM_JOINTS
    phase = np.linspace(0.0, 1.0, per_order)
    values = [bezier.evaluate(coefficients, phase, order) for order in range(ORDERS)]
    scaled = [value / scale for value, scale in zip(values, _SCALES, strict=True)]
    return np.stack(scaled, axis=1).ravel()


@dataclass(frozen=True)
class Layout:
    """Places of the variables of two steps."""

    nodes: int
    joints: Transcription

    @classmethod
    def of(cls, config: FormulationConfig) -> "Layout":
        """The configured transcription."""
        if config.transcription == "bezier":
            return cls(config.nodes, bezier_joints(config.nodes, config.degree))
        return cls(config.nodes, collocated_joints(config.nodes))

    @property
    def step_size(self) -> int:
        """Variables of a step."""
        return self.joints.size + 1 + ROLL_STATES * self.nodes

    @property
    def size(self) -> int:
        """Variables of a walk."""
        return 2 * self.step_size

    @property
    def phase(self) -> np.ndarray:
        """Phases of the nodes (nodes,)."""
        return np.linspace(0.0, 1.0, self.nodes)

    @property
    def intervals(self) -> int:
        """Pieces of the collocation per step, each with a node in its middle."""
        return (self.nodes - 1) // 2

    def joint_slice(self, step: int) -> slice:
        """Joint variables of a step."""
        return slice(step * self.step_size, step * self.step_size + self.joints.size)

    def time_index(self, step: int) -> int:
        """Position of a step's duration in the variables."""
        return step * self.step_size + self.joints.size

    def roll_index(self, step: int, node: int) -> int:
        """Position of a node's roll in the variables; rate and acceleration follow."""
        return self.time_index(step) + 1 + ROLL_STATES * node

    @cached_property
    def weights(self) -> np.ndarray:
        """Simpson weights (2 · nodes,) of a mean over each step."""
        single = np.ones(self.nodes)
        single[1:-1:2], single[2:-1:2] = 4.0, 2.0
        return np.tile(single / single.sum(), 2)

    @cached_property
    def select_nodes(self) -> ca.DM:
        """Matrix (2 · nodes · 34, size) from variables to node vectors."""
        return _sparse(self._nodes)

    @cached_property
    def turns(self) -> np.ndarray:
        """Sign of the yaw rate and phase from −½ to ½ (2, 2 · nodes): the second is reflected."""
        signs = np.repeat([1.0, -1.0], self.nodes)
        return np.stack([signs, np.tile(self.phase - 0.5, 2)])

    def node_vectors(self, variables: np.ndarray) -> np.ndarray:
        """Vectors (2, nodes, 34) of all nodes of both steps, the second one reflected."""
        return (self.select_nodes @ variables).full().reshape(2, self.nodes, NODE)

    @cached_property
    def _nodes(self) -> np.ndarray:
        rolls = np.eye(ROLL_STATES * self.nodes)
        step = _diagonal(self.joints.nodes, np.eye(1), rolls)[self._node_rows()]
        return _diagonal(step, step)

    def _node_rows(self) -> np.ndarray:
        """Rows of (joint orders, time, rolls) that make up the node vectors of a step."""
        per_order = self.nodes * NUM_JOINTS
        joints = np.arange(ORDERS * per_order).reshape(ORDERS, self.nodes, NUM_JOINTS)
        time = ORDERS * per_order
        rolls = time + 1 + np.arange(ROLL_STATES * self.nodes).reshape(self.nodes, ROLL_STATES)
        times = np.full((self.nodes, 1), time)
        return np.concatenate([rolls, *joints, times], axis=1).ravel()

    @cached_property
    def select_ends(self) -> ca.DM:
        """Matrix (2 · 45, size) from variables to the starts and ends of the steps."""
        end = np.r_[0:2, ROLL_STATES : ROLL_STATES + 2 * NUM_JOINTS]
        rows = []
        for step in range(2):
            first = step * self.nodes * NODE
            last = first + (self.nodes - 1) * NODE
            rows += [first + end, last + end, [first + NODE - 1]]
        return _sparse(self._nodes[np.concatenate(rows)])

    @cached_property
    def joint_defects(self) -> ca.DM:
        """Rows (n, size) of both steps that are zero for a valid joint motion."""
        defects = self.joints.defects
        step = np.pad(defects, ((0, 0), (0, self.step_size - self.joints.size)))
        return _sparse(_diagonal(step, step))


def _sparse(matrix: np.ndarray) -> ca.DM:
    """The same without its zeros. SciPy, imported for such matrices alone, takes 0.07 s."""
    rows, columns = np.nonzero(matrix)
    values = ca.DM(matrix[rows, columns])
    return ca.DM.triplet(rows.tolist(), columns.tolist(), values, *matrix.shape)


def _diagonal(*blocks: np.ndarray) -> np.ndarray:
    rows, columns = np.cumsum([block.shape for block in blocks], axis=0).T
    matrix = np.zeros((rows[-1], columns[-1]))
    for block, row, column in zip(blocks, rows, columns, strict=True):
        matrix[row - block.shape[0] : row, column - block.shape[1] : column] = block
    return matrix
