"""Variables of a walk, and constant matrices from them to nodes and step ends.

Variables of a step: Bézier coefficients of the ten joints, joint by joint (virtual constraints),
step time, and roll, roll rate and roll acceleration of the stance foot at every node.
"""

from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from slider.gait import bezier
from slider.gait.formulation import NodeSymbols
from slider.gait.tree import NUM_JOINTS

ORDERS = 3  # positions and their first and second derivatives with respect to the phase
NODE = NodeSymbols.SIZE
END = 2 + 2 * NUM_JOINTS  # roll, roll rate, joints, joint rates over normalised time
STEP = 2 * END + 1  # start, end, step time
ROLL_STATES = 3


@dataclass(frozen=True)
class Layout:
    """Positions of the variables of two steps in their vector."""

    nodes: int
    degree: int

    @property
    def coefficients(self) -> int:
        """Bézier coefficients of a step."""
        return NUM_JOINTS * (self.degree + 1)

    @property
    def step_size(self) -> int:
        """Variables of a step."""
        return self.coefficients + 1 + ROLL_STATES * self.nodes

    @property
    def size(self) -> int:
        """Variables of a walk."""
        return 2 * self.step_size

    @property
    def phase(self) -> np.ndarray:
        """Phases of the nodes (nodes,)."""
        return np.linspace(0.0, 1.0, self.nodes)

    def joint_slice(self, step: int) -> slice:
        """Bézier coefficients of a step."""
        return slice(step * self.step_size, step * self.step_size + self.coefficients)

    def time_index(self, step: int) -> int:
        """Position of a step's duration in the variables; roll states of its nodes follow."""
        return step * self.step_size + self.coefficients

    @cached_property
    def weights(self) -> np.ndarray:
        """Simpson weights (2 · nodes,) of a mean over each step."""
        single = np.ones(self.nodes)
        single[1:-1:2], single[2:-1:2] = 4.0, 2.0
        return np.tile(single / single.sum(), 2)

    @cached_property
    def turns(self) -> np.ndarray:
        """Sign of the yaw rate, −1 in the reflected step, and phase from −½ to ½ (2, 2 · nodes)."""
        signs = np.repeat([1.0, -1.0], self.nodes)
        return np.stack([signs, np.tile(self.phase - 0.5, 2)])

    @cached_property
    def select_nodes(self) -> ca.DM:
        """Sparse matrix (2 · nodes · 34, size) from variables to node vectors."""
        per_order, states = self.nodes * NUM_JOINTS, ROLL_STATES * self.nodes
        bases = np.stack(bezier.basis_orders(self.degree, self.phase, ORDERS))
        matrix = np.einsum("okw,ij->okijw", bases, np.eye(NUM_JOINTS))
        matrix = matrix.reshape(-1, self.coefficients)
        parts = ca.sparsify(ca.DM(matrix)), ca.DM.eye(1 + states)
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
