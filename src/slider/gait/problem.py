"""A gait problem: symbolic functions with exact derivatives, bounds and names, for a solver.

Built once (``build``), then assembled for IPOPT and solved for many velocities in
``slider.gait.solve``.
"""

from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from slider.core.casadi_code import Functions, Source, interpreted
from slider.gait.constraints import (
    ROLL_BOUNDS,
    Constraint,
    joint_bounds,
    of_node,
    of_walk,
    scaled_bounds,
    scaled_rows,
)
from slider.gait.costs import COSTS
from slider.gait.formulation import Formulation, Node, StepEnd
from slider.gait.transcription import END, NODE, ROLL_STATES, STEP, Layout
from slider.gait.tree import NUM_JOINTS
from slider.robot.names import VELOCITY

Bounds = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Block:
    """Rows of one named constraint in the stacked vector."""

    name: str
    scale: float
    rows: np.ndarray


@dataclass(frozen=True)
class GaitProblem:
    """Everything that a solver needs except velocity, bounds of the step time and its options.

    Attributes:
        form: the formulation of the gait.
        layout: of the variables.
        functions: with derivatives, rows scaled, by the names of ``build``.
        node_constraints, end_constraints: of the rows of a node and of the step ends.
    """

    form: Formulation
    layout: Layout
    functions: Functions
    node_constraints: list[Constraint]
    end_constraints: list[Constraint]

    @cached_property
    def row_counts(self) -> tuple[int, int, int]:
        """Rows of one node, of the collocation and of the step ends."""
        node = sum(c.size for c in self.node_constraints)
        ends = sum(c.size for c in self.end_constraints)
        return node, self.functions["collocation"].size1_out(0), ends

    @cached_property
    def row_bounds(self) -> Bounds:
        """Scaled lower and upper bounds of all rows."""
        zero = np.zeros(self.row_counts[1])
        nodes = scaled_bounds(self.node_constraints, self.layout.phase)
        ends = scaled_bounds(self.end_constraints, np.zeros(1))
        lower, upper = (
            np.concatenate([node.ravel(), node.ravel(), zero, end[0]])
            for node, end in zip(nodes, ends, strict=True)
        )
        return lower, upper

    @cached_property
    def blocks(self) -> list[Block]:
        """Rows of each named constraint, for residuals by name."""
        node_rows, collocation_rows, _ = self.row_counts
        first = 2 * self.layout.nodes * node_rows
        collocation = Block("collocation", 1.0, first + np.arange(collocation_rows))
        ends = blocks_of(self.end_constraints, 1, first + collocation_rows)
        return [*blocks_of(self.node_constraints, 2 * self.layout.nodes), collocation, *ends]

    def variable_bounds(self, duration: tuple[float, float]) -> Bounds:
        """Lower and upper bounds of the variables, the step time within ``duration`` [s].

        The second step's time equals the first one's; bounds on it too would be redundant, which
        leaves the multipliers undetermined.
        """
        rolls = np.tile(ROLL_BOUNDS, self.layout.nodes)
        sides = []
        for sign, joints, time in zip((-1.0, 1.0), joint_bounds(self.form), duration, strict=True):
            step = np.repeat(joints, self.layout.degree + 1)  # a polynomial stays in its hull
            sides.append(np.tile(np.concatenate([step, [time], sign * rolls]), 2))
        second = self.layout.time_index(1)
        sides[0][second], sides[1][second] = duration[0] / 2, duration[1] * 2
        return sides[0], sides[1]


def blocks_of(constraints: list[Constraint], count: int, first: int = 0) -> list[Block]:
    """Blocks of rows that repeat ``count`` times from row ``first`` on."""
    starts = np.arange(count) * sum(constraint.size for constraint in constraints)
    blocks = []
    for constraint in constraints:
        rows = (starts[:, None] + first + np.arange(constraint.size)).ravel()
        blocks.append(Block(constraint.name, constraint.scale, rows))
        first += constraint.size
    return blocks


def worst_of(
    values: np.ndarray, lower: ArrayLike, upper: ArrayLike, scale: float = 1.0
) -> tuple[float, str]:
    """Largest excess of scaled values over their bounds, and its text; ``0.951, at least 1``."""
    lower, upper = (np.broadcast_to(side, values.shape) for side in (lower, upper))
    beyond = excess(values, lower, upper)
    row = int(beyond.argmax())
    value, least, most = (float(each[row] * scale) for each in (values, lower, upper))
    side, bound = ("at least", least) if value < least else ("at most", most)
    return float(beyond[row] * scale), f"{value:.3g}, {side if least < most else 'not'} {bound:.3g}"


def excess(values: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Distance of each value from its interval; zero inside."""
    return np.maximum(np.maximum(lower - values, values - upper), 0.0)


def build(form: Formulation, functions: Source = interpreted) -> GaitProblem:
    """Derive all functions of a formulation, or take them from ``functions``.

    ``node``: (x, weight, turn) → cost, rows; ``node_jacobian``: (x, turn) → rows, their Jacobian;
    ``node_hessian``: (x, weight, turn, factor, multipliers) → symmetric (34, 34), of a node's
    vector x (34,), its Simpson weight and ``turn`` (2,), see ``Node``; ``cost``: (x, weight) →
    cost, gradient; ``quantities``: x → see ``Node.stored``; ``ends``, ``ends_jacobian`` and
    ``ends_hessian``: rows of the step ends y (90,) and the velocity (3,); ``collocation`` with its
    derivatives: Hermite-Simpson defects of all variables.
    """
    layout = Layout(form.config.nodes, form.config.degree)
    x, turn = ca.SX.sym("x", NODE), ca.SX.sym("turn", 2)
    node = Node(form, x, turn)
    node_constraints = of_node(node)
    y, velocity = ca.SX.sym("y", 2 * STEP), ca.SX.sym("p", len(VELOCITY))
    times = [step[-1] for step in ca.vertsplit(y, STEP)]
    starts = [_step_end(step[:END], step[-1]) for step in ca.vertsplit(y, STEP)]
    ends = [_step_end(step[END:-1], step[-1]) for step in ca.vertsplit(y, STEP)]
    end_constraints = of_walk(form, starts, ends, times, velocity)

    def derive() -> Functions:
        z = ca.SX.sym("z", layout.size)
        parts = [
            *_node_functions(node, node_constraints, x, turn),
            *_derived("ends", scaled_rows(end_constraints), y, velocity),
            *_derived("collocation", _defects(layout, z), z),
        ]
        return {function.name(): function for function in parts}

    derived = functions(form.parameters, derive)
    return GaitProblem(form, layout, derived, node_constraints, end_constraints)


def _step_end(state: ca.SX, step_time: ca.SX) -> StepEnd:
    q, q_phase = state[2 : 2 + NUM_JOINTS], state[2 + NUM_JOINTS :]
    return StepEnd(state[0], state[1], q, q_phase / step_time)


def _node_functions(
    node: Node, constraints: list[Constraint], x: ca.SX, turn: ca.SX
) -> list[ca.Function]:
    weight, cost = ca.SX.sym("w"), COSTS[node.form.config.cost]
    rows, cost = scaled_rows(constraints), cost.scale * cost.node(node, weight)
    multiplier, factor = ca.SX.sym("lam", rows.numel()), ca.SX.sym("f")
    hessian = _symmetric(factor * cost + ca.dot(multiplier, rows), x)
    return [
        ca.Function("node", [x, weight, turn], [cost, rows]),
        ca.Function("node_jacobian", [x, turn], [rows, ca.jacobian(rows, x)]),
        ca.Function("node_hessian", [x, weight, turn, factor, multiplier], [hessian]),
        ca.Function("cost", [x, weight], [cost, ca.gradient(cost, x)]),
        ca.Function("quantities", [x], Node(node.form, x, ca.SX(2, 1)).stored()),
    ]


def _derived(name: str, rows: ca.SX, x: ca.SX, *parameters: ca.SX) -> list[ca.Function]:
    """Rows, and their first and second derivatives with respect to x."""
    multiplier = ca.SX.sym("lam", rows.numel())
    hessian = _symmetric(ca.dot(multiplier, rows), x)
    return [
        ca.Function(name, [x, *parameters], [rows]),
        ca.Function(f"{name}_jacobian", [x, *parameters], [rows, ca.jacobian(rows, x)]),
        ca.Function(f"{name}_hessian", [x, *parameters, multiplier], [hessian]),
    ]


def _symmetric(value: ca.SX, x: ca.SX) -> ca.SX:
    """Hessian that is exactly symmetric: its lower triangle copies the upper one."""
    return ca.triu2symm(ca.triu(ca.hessian(value, x)[0]))


def _defects(layout: Layout, z: ca.SX) -> ca.SX:
    """Hermite-Simpson defects, separated form, of roll and roll rate."""
    rows = []
    for step in range(2):
        time = layout.time_index(step)
        interval = z[time] / ((layout.nodes - 1) // 2)  # with a node in its middle
        for k in range(0, layout.nodes - 1, 2):
            first = time + 1 + ROLL_STATES * k
            a, m, b = (z[first + ROLL_STATES * j : first + ROLL_STATES * (j + 1)] for j in range(3))
            for i in range(2):
                rows.append(m[i] - (a[i] + b[i]) / 2 - interval / 8 * (a[i + 1] - b[i + 1]))
                mean = (a[i + 1] + 4 * m[i + 1] + b[i + 1]) / 6
                rows.append(b[i] - a[i] - interval * mean)
    return ca.vertcat(*rows)
