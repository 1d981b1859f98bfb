"""The nonlinear programme of one gait: Bézier joints, collocated roll, exact derivatives.

Variables of a step: Bézier coefficients of the ten joints, step time, and roll, roll rate and
roll acceleration of the stance foot at every node. Small symbolic functions of one node are mapped
over all nodes; their Jacobians and Hessians are assembled by constant selection matrices.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np
import scipy.sparse as sp

from slider.gait import bezier
from slider.gait.constraint import Constraint
from slider.gait.formulation import Formulation
from slider.gait.symbols import NodeSymbols, StepEnd
from slider.gait.tree import NUM_JOINTS

NODE = NodeSymbols.SIZE
END = 2 + 2 * NUM_JOINTS  # roll, roll rate, joints, joint rates over normalised time
STEP = 2 * END + 1  # start, end, step time
ROLL_STATES = 3
PAPER_COST_SCALE, TORQUE_COST_SCALE = 1e-4, 1e-3  # brings the objective near 1


@dataclass(frozen=True)
class Block:
    """Rows of one named constraint in the stacked vector."""

    name: str
    unit: str
    scale: float
    rows: np.ndarray


@dataclass(frozen=True)
class Piece:
    """A symbolic function with first and second derivatives."""

    value: ca.Function
    jacobian: ca.Function
    hessian: ca.Function


class GaitProblem:
    """Builds the functions, bounds and names; solving is ``slider.gait.solve``."""

    def __init__(self, formulation: Formulation) -> None:
        self.formulation = formulation
        config = formulation.config
        self.nodes, self.degree = config.nodes, config.degree
        self.num_coefficients = NUM_JOINTS * (self.degree + 1)
        self.step_size = self.num_coefficients + 1 + ROLL_STATES * self.nodes
        self.size = 2 * self.step_size
        self._node_constraints: list[Constraint] = []
        self._end_constraints: list[Constraint] = []
        self.node = self._node_piece()
        self.ends = self._ends_piece()
        self.collocation = self._collocation_piece()

    # --- layout ----------------------------------------------------------------------------

    def time_index(self, step: int) -> int:
        """Position of a step's duration in the variables."""
        return step * self.step_size + self.num_coefficients

    def roll_index(self, step: int, node: int) -> int:
        """Position of a node's roll in the variables; rate and acceleration follow."""
        return self.time_index(step) + 1 + ROLL_STATES * node

    @cached_property
    def select_nodes(self) -> sp.csc_matrix:
        """Matrix (2 · nodes · 34, size) from variables to node vectors."""
        matrix = sp.lil_matrix((2 * self.nodes * NODE, self.size))
        phase = self.formulation.phase
        bases = [bezier.basis_derivative(self.degree, phase, order) for order in range(3)]
        width = self.degree + 1
        for step in range(2):
            for k in range(self.nodes):
                row = (step * self.nodes + k) * NODE
                for state in range(ROLL_STATES):
                    matrix[row + state, self.roll_index(step, k) + state] = 1.0
                for order, values in enumerate(bases):
                    for joint in range(NUM_JOINTS):
                        column = step * self.step_size + joint * width
                        place = row + ROLL_STATES + order * NUM_JOINTS + joint
                        matrix[place, column : column + width] = values[k]
                matrix[row + NODE - 1, self.time_index(step)] = 1.0
        return _clean(matrix)

    @cached_property
    def select_ends(self) -> sp.csc_matrix:
        """Matrix (2 · 45, size) from variables to the starts and ends of the steps."""
        matrix = sp.lil_matrix((2 * STEP, self.size))
        nodes = self.select_nodes.tolil()
        for step in range(2):
            for end, k in enumerate((0, self.nodes - 1)):
                row = step * STEP + end * END
                source = (step * self.nodes + k) * NODE
                matrix[row : row + 2] = nodes[source : source + 2]
                joints = slice(source + ROLL_STATES, source + ROLL_STATES + 2 * NUM_JOINTS)
                matrix[row + 2 : row + END] = nodes[joints]
            matrix[(step + 1) * STEP - 1, self.time_index(step)] = 1.0
        return _clean(matrix)

    # --- symbolic pieces -------------------------------------------------------------------

    def _node_piece(self) -> Piece:
        x, weight = ca.SX.sym("x", NODE), ca.SX.sym("w")
        self._node_constraints, torque2 = self.formulation.node(x)
        cost = self._node_cost(torque2, weight, x[-1])
        rows = _scaled(self._node_constraints)
        multiplier, factor = ca.SX.sym("lam", rows.numel()), ca.SX.sym("f")
        hessian, _ = ca.hessian(factor * cost + ca.dot(multiplier, rows), x)
        full = ca.triu2symm(ca.triu(hessian))
        self.gradient = ca.Function("cost", [x, weight], [cost, ca.gradient(cost, x)])
        return Piece(
            ca.Function("node", [x, weight], [cost, rows]),
            ca.Function("node_jacobian", [x], [rows, ca.jacobian(rows, x)]),
            ca.Function("node_hessian", [x, weight, factor, multiplier], [full]),
        )

    def _node_cost(self, torque2: ca.SX, weight: ca.SX, step_time: ca.SX) -> ca.SX:
        if self.formulation.config.cost == "paper":
            return PAPER_COST_SCALE * torque2 / step_time
        return TORQUE_COST_SCALE * weight * torque2

    @property
    def cost_scale(self) -> float:
        """Factor of the solver's objective on the cost in SI units."""
        paper = self.formulation.config.cost == "paper"
        return PAPER_COST_SCALE if paper else TORQUE_COST_SCALE

    @cached_property
    def weights(self) -> np.ndarray:
        """Simpson weights (2 · nodes,) of a mean over each step."""
        single = np.ones(self.nodes)
        single[1:-1:2], single[2:-1:2] = 4.0, 2.0
        return np.tile(single / single.sum(), 2)

    def _ends_piece(self) -> Piece:
        y, velocity = ca.SX.sym("y", 2 * STEP), ca.SX.sym("p", 2)
        self._end_constraints = self._connect(y, velocity)
        rows = _scaled(self._end_constraints)
        multiplier = ca.SX.sym("lam", rows.numel())
        hessian, _ = ca.hessian(ca.dot(multiplier, rows), y)
        full = ca.triu2symm(ca.triu(hessian))
        return Piece(
            ca.Function("ends", [y, velocity], [rows]),
            ca.Function("ends_jacobian", [y, velocity], [rows, ca.jacobian(rows, y)]),
            ca.Function("ends_hessian", [y, velocity, multiplier], [full]),
        )

    def _connect(self, y: ca.SX, velocity: ca.SX) -> list[Constraint]:
        """Touchdowns of both steps, mean velocity, equal step times and forward step lengths.

        Without equal lengths the cheapest slow walk keeps one foot 0.4 m ahead of the other.
        """
        form = self.formulation
        starts, stops, times = [], [], []
        for step in range(2):
            part = y[step * STEP : (step + 1) * STEP]
            starts.append(_step_end(part[:END], part[-1]))
            stops.append(_step_end(part[END : 2 * END], part[-1]))
            times.append(part[-1])
        left = form.touchdown(stops[0], starts[1])
        right = form.touchdown(stops[1], starts[0])
        travel = [form.step_vector(stop) for stop in stops]
        walk = times[0] + times[1]
        mean = ca.vertcat(
            travel[0][0] + travel[1][0] - velocity[0] * walk,
            travel[0][1] - travel[1][1] - velocity[1] * walk,  # the second step is reflected
        )
        zero = np.zeros(2)
        return [
            *left,
            *right,
            Constraint("mean_velocity", "m", "command", mean, zero, zero, 0.1),
            _symmetry("equal_step_times", "s", times[0] - times[1], 1.0),
            _symmetry("equal_step_lengths", "m", travel[0][0] - travel[1][0], 0.1),
        ]

    def _collocation_piece(self) -> Piece:
        """Hermite-Simpson defects of roll and roll rate, separated form."""
        z = ca.SX.sym("z", self.size)
        rows = []
        for step in range(2):
            interval = z[self.time_index(step)] / ((self.nodes - 1) // 2)
            for k in range(0, self.nodes - 1, 2):
                a, m, b = (
                    z[self.roll_index(step, j) : self.roll_index(step, j) + ROLL_STATES]
                    for j in (k, k + 1, k + 2)
                )
                for i in range(2):
                    rows.append(m[i] - (a[i] + b[i]) / 2 - interval / 8 * (a[i + 1] - b[i + 1]))
                    mean = (a[i + 1] + 4 * m[i + 1] + b[i + 1]) / 6
                    rows.append(b[i] - a[i] - interval * mean)
        defects = ca.vertcat(*rows)
        multiplier = ca.SX.sym("lam", defects.numel())
        hessian, _ = ca.hessian(ca.dot(multiplier, defects), z)
        return Piece(
            ca.Function("collocation", [z], [defects]),
            ca.Function("collocation_jacobian", [z], [defects, ca.jacobian(defects, z)]),
            ca.Function("collocation_hessian", [z, multiplier], [hessian]),
        )

    # --- names and bounds ------------------------------------------------------------------

    @cached_property
    def row_counts(self) -> tuple[int, int, int]:
        """Rows of one node, of the collocation and of the step ends."""
        node = sum(c.size for c in self._node_constraints)
        ends = sum(c.size for c in self._end_constraints)
        return node, self.collocation.value.size1_out(0), ends

    @cached_property
    def row_bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Scaled lower and upper bounds of all rows."""
        collocation = np.zeros(self.row_counts[1])
        bounds = []
        for side in ("lower", "upper"):
            node = [_over_nodes(c, side, self.nodes) for c in self._node_constraints]
            ends = [getattr(c, side) / c.scale for c in self._end_constraints]
            step = np.concatenate(node, axis=1)
            bounds.append(np.concatenate([step.ravel(), step.ravel(), collocation, *ends]))
        return bounds[0], bounds[1]

    @cached_property
    def blocks(self) -> list[Block]:
        """Where each named constraint is, for residuals by name."""
        node_rows, collocation_rows, _ = self.row_counts
        total = 2 * self.nodes * node_rows
        blocks, offset = [], 0
        starts = np.arange(2 * self.nodes) * node_rows
        for c in self._node_constraints:
            rows = (starts[:, None] + offset + np.arange(c.size)).ravel()
            blocks.append(Block(c.name, c.unit, c.scale, rows))
            offset += c.size
        blocks.append(Block("collocation", "rad", 1.0, total + np.arange(collocation_rows)))
        offset = total + collocation_rows
        for c in self._end_constraints:
            blocks.append(Block(c.name, c.unit, c.scale, offset + np.arange(c.size)))
            offset += c.size
        return blocks

    @cached_property
    def variable_bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper bounds of the variables.

        The second step's time equals the first one's; bounds on it too would be redundant, which
        leaves the multipliers undetermined.
        """
        config, limits = self.formulation.config, self.formulation.limits
        lower, upper = [], []
        for name in ("hip_yaw", "hip_roll", None, "knee", None):
            if name == "knee":
                bounds = (config.posture.knee_min, config.posture.knee_max)
            elif name is None:  # hip pitch and ankle are bounded after eq. 1, at the nodes
                bounds = (-np.pi, np.pi)
            else:
                bounds = (limits[name].lower, limits[name].upper)
            lower += [bounds[0]] * (self.degree + 1)
            upper += [bounds[1]] * (self.degree + 1)
        roll = np.tile([0.6, 6.0, 200.0], self.nodes)  # generous: the solution stays inside
        time = config.step_time
        lower = np.tile(np.concatenate([lower, lower, [time.lower], -roll]), 2)
        upper = np.tile(np.concatenate([upper, upper, [time.upper], roll]), 2)
        lower[self.time_index(1)], upper[self.time_index(1)] = time.lower / 2, time.upper * 2
        return lower, upper


def _step_end(part: ca.SX, step_time: ca.SX) -> StepEnd:
    n = NUM_JOINTS
    return StepEnd(part[0], part[1], part[2 : 2 + n], part[2 + n :] / step_time)


def _symmetry(name: str, unit: str, difference: ca.SX, scale: float) -> Constraint:
    zero = np.zeros(1)
    return Constraint(name, unit, "symmetry", difference, zero, zero, scale)


def _scaled(constraints: Sequence[Constraint]) -> ca.SX:
    return ca.vertcat(*[c.expression / c.scale for c in constraints])


def _over_nodes(constraint: Constraint, side: str, nodes: int) -> np.ndarray:
    values = np.asarray(getattr(constraint, side)) / constraint.scale
    return np.broadcast_to(values, (nodes, constraint.size))


def _clean(matrix: sp.lil_matrix) -> sp.csc_matrix:
    result = matrix.tocsc()
    result.eliminate_zeros()
    return result
