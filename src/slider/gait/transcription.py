"""Variables of a walk, and constant matrices from them to nodes and step ends.

Variables of a step: joint variables, step time, and roll, roll rate and roll acceleration of the
stance foot at every node. The joints' motion over a step is linear in its variables, in two ways.
``bezier``: virtual constraints, polynomials of the phase. ``collocation``: positions, velocities
and accelerations of all joints at every node, tied by Hermite-Simpson defects.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import casadi as ca
import numpy as np

from slider.config.gait import FormulationConfig
from slider.gait import bezier
from slider.gait.formulation import NodeSymbols
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
    phase = np.linspace(0.0, 1.0, nodes)
    bases = np.stack(bezier.basis_orders(degree, phase, ORDERS))
    matrix = np.einsum("okw,ij->okijw", bases, np.eye(NUM_JOINTS))
    size = NUM_JOINTS * (degree + 1)
    joints = np.repeat(np.arange(NUM_JOINTS), degree + 1)  # a polynomial stays in its hull
    return Transcription(size, matrix.reshape(-1, size), np.zeros((0, size)), joints)


def collocated_joints(nodes: int) -> Transcription:
    """Values of the three orders at every node, node by node."""
    size = nodes * ORDERS * NUM_JOINTS
    eye = np.eye(size).reshape(nodes, ORDERS, NUM_JOINTS, size)
    orders = [eye[:, order] * _SCALES[order] for order in range(ORDERS)]
    joints = np.full((nodes, ORDERS, NUM_JOINTS), -1)
    joints[:, 0] = np.arange(NUM_JOINTS)
    defects, interval = [], 2.0 / (nodes - 1)
    for value, slope in pairwise(orders):  # Hermite-Simpson, separated form
        (a, m, b), (da, dm, db) = (
            (each[:-2:2], each[1:-1:2], each[2::2]) for each in (value, slope)
        )
        defects.append(m - (a + b) / 2 - interval / 8 * (da - db))
        defects.append(b - a - interval / 6 * (da + 4 * dm + db))
    nodes_of, zero = (np.concatenate(each).reshape(-1, size) for each in (orders, defects))
    return Transcription(size, nodes_of, zero, joints.ravel())


def from_polynomials(transcription: Transcription, coefficients: np.ndarray) -> np.ndarray:
    """Variables (size,) of Bézier polynomials (10, degree + 1); exact where they are the same."""
    if transcription.size == coefficients.size and not len(transcription.defects):
        return coefficients.ravel()
    nodes = len(transcription.nodes) // ORDERS // NUM_JOINTS
    phase = np.linspace(0.0, 1.0, nodes)
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

    def joint_slice(self, step: int) -> slice:
        """Joint variables of a step."""
        return slice(step * self.step_size, step * self.step_size + self.joints.size)

    def time_index(self, step: int) -> int:
        """Position of a step's duration in the variables; roll states of its nodes follow."""
        return step * self.step_size + self.joints.size

    @cached_property
    def weights(self) -> np.ndarray:
        """Simpson weights (2 · nodes,) of a mean over each step."""
        single = np.ones(self.nodes)
        single[1:-1:2], single[2:-1:2] = 4.0, 2.0
        return np.tile(single / single.sum(), 2)

    @cached_property
    def turns(self) -> np.ndarray:
        """Sign of the yaw rate and phase from −½ to ½ (2, 2 · nodes): the second is reflected."""
        signs = np.repeat([1.0, -1.0], self.nodes)
        return np.stack([signs, np.tile(self.phase - 0.5, 2)])

    @cached_property
    def select_nodes(self) -> ca.DM:
        """Sparse matrix (2 · nodes · 34, size) from variables to node vectors."""
        per_order, states = self.nodes * NUM_JOINTS, ROLL_STATES * self.nodes
        parts = ca.sparsify(ca.DM(self.joints.nodes)), ca.DM.eye(1 + states)
        joints = np.arange(ORDERS * per_order).reshape(ORDERS, self.nodes, NUM_JOINTS)
        times = np.full((self.nodes, 1), ORDERS * per_order)
        rolls = times + 1 + np.arange(states).reshape(self.nodes, ROLL_STATES)
        rows = np.concatenate([rolls, *joints, times], axis=1).ravel()
        step = ca.diagcat(*parts)[rows.tolist(), :]
        return ca.diagcat(step, step)

    def node_vectors(self, variables: np.ndarray) -> np.ndarray:
        """Vectors (2, nodes, 34) of all nodes of both steps, the second one reflected."""
        return (self.select_nodes @ variables).full().reshape(2, self.nodes, NODE)

    @cached_property
    def select_ends(self) -> ca.DM:
        """Sparse matrix (2 · 45, size) from variables to the starts and ends of the steps."""
        end = np.r_[0:2, ROLL_STATES : ROLL_STATES + 2 * NUM_JOINTS]
        rows = []
        for step in range(2):
            first = step * self.nodes * NODE
            last = first + (self.nodes - 1) * NODE
            rows += [*(first + end), *(last + end), first + NODE - 1]
        return self.select_nodes[[int(row) for row in rows], :]

    @cached_property
    def joint_defects(self) -> ca.DM:
        """Sparse rows (n, size) of both steps that are zero for a valid joint motion."""
        defects = self.joints.defects
        rest = ca.DM(len(defects), self.step_size - self.joints.size)
        step = ca.horzcat(ca.sparsify(ca.DM(defects)), rest)
        return ca.diagcat(step, step)
