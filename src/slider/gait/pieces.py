"""Symbolic functions of a node, of the step ends and of the collocation, with exact derivatives."""

from dataclasses import dataclass

import casadi as ca

from slider.gait import constraints
from slider.gait.constraint import Constraint, scaled_rows
from slider.gait.costs import COSTS
from slider.gait.formulation import Formulation
from slider.gait.layout import END, NODE, ROLL_STATES, STEP, Layout
from slider.gait.motion import Node
from slider.gait.symbols import StepEnd
from slider.gait.tree import NUM_JOINTS
from slider.robot.names import COMMAND


@dataclass(frozen=True)
class Piece:
    """A symbolic function with first and second derivatives."""

    value: ca.Function
    jacobian: ca.Function
    hessian: ca.Function


@dataclass(frozen=True)
class NodeTerms:
    """A node as a function of its vector x (34,) and of ``turn`` (2,), see ``Node.of``."""

    form: Formulation
    x: ca.SX
    turn: ca.SX
    node: Node
    constraints: list[Constraint]

    @classmethod
    def of(cls, form: Formulation) -> "NodeTerms":
        """Of a formulation."""
        x, turn = ca.SX.sym("x", NODE), ca.SX.sym("turn", 2)
        node = Node.of(form, x, turn)
        return cls(form, x, turn, node, constraints.of_node(node))

    def functions(self) -> list[ca.Function]:
        """Cost and constraints, their derivatives and what a gait stores.

        ``node``: (x, weight, turn) → cost, rows; ``node_jacobian``: (x, turn) → rows, their
        Jacobian; ``node_hessian``: (x, weight, turn, factor, multipliers) → symmetric (34, 34);
        ``cost``: (x, weight) → cost, gradient; ``quantities``: x → see ``Node.stored``.
        """
        x, turn, weight = self.x, self.turn, ca.SX.sym("w")
        cost = COSTS[self.form.config.cost]
        rows, cost = scaled_rows(self.constraints), cost.scale * cost.node(self.node, weight)
        multiplier, factor = ca.SX.sym("lam", rows.numel()), ca.SX.sym("f")
        hessian, _ = ca.hessian(factor * cost + ca.dot(multiplier, rows), x)
        full = ca.triu2symm(ca.triu(hessian))
        return [
            ca.Function("node", [x, weight, turn], [cost, rows]),
            ca.Function("node_jacobian", [x, turn], [rows, ca.jacobian(rows, x)]),
            ca.Function("node_hessian", [x, weight, turn, factor, multiplier], [full]),
            ca.Function("cost", [x, weight], [cost, ca.gradient(cost, x)]),
            ca.Function("quantities", [x], Node.of(self.form, x, ca.SX(2, 1)).stored()),
        ]


@dataclass(frozen=True)
class WalkTerms:
    """Touchdowns and periodicity: functions of the step ends y (90,) and the command (3,)."""

    y: ca.SX
    command: ca.SX
    constraints: list[Constraint]

    @classmethod
    def of(cls, form: Formulation) -> "WalkTerms":
        """Of a formulation."""
        y, command = ca.SX.sym("y", 2 * STEP), ca.SX.sym("p", len(COMMAND))
        return cls(y, command, _walk(form, y, command))

    def functions(self) -> list[ca.Function]:
        """``ends``: rows, ``ends_jacobian``: rows, their Jacobian, ``ends_hessian``: symmetric."""
        y, command, rows = self.y, self.command, scaled_rows(self.constraints)
        multiplier = ca.SX.sym("lam", rows.numel())
        hessian, _ = ca.hessian(ca.dot(multiplier, rows), y)
        full = ca.triu2symm(ca.triu(hessian))
        return [
            ca.Function("ends", [y, command], [rows]),
            ca.Function("ends_jacobian", [y, command], [rows, ca.jacobian(rows, y)]),
            ca.Function("ends_hessian", [y, command, multiplier], [full]),
        ]


def _walk(form: Formulation, y: ca.SX, command: ca.SX) -> list[Constraint]:
    steps = [y[step * STEP : (step + 1) * STEP] for step in range(2)]
    times = [step[-1] for step in steps]
    starts = [_step_end(step[:END], step[-1]) for step in steps]
    ends = [_step_end(step[END : 2 * END], step[-1]) for step in steps]
    return constraints.of_walk(form, starts, ends, times, command)


def _step_end(part: ca.SX, step_time: ca.SX) -> StepEnd:
    n = NUM_JOINTS
    return StepEnd(part[0], part[1], part[2 : 2 + n], part[2 + n :] / step_time)


def collocation(layout: Layout) -> list[ca.Function]:
    """Hermite-Simpson defects, separated form, of roll, roll rate and collocated joints."""
    z = ca.SX.sym("z", layout.size)
    rolls = [row for step in range(2) for row in _roll_defects(layout, z, step)]
    defects = ca.vertcat(*rolls, ca.mtimes(layout.joint_defects, z))
    multiplier = ca.SX.sym("lam", defects.numel())
    hessian, _ = ca.hessian(ca.dot(multiplier, defects), z)
    return [
        ca.Function("collocation", [z], [defects]),
        ca.Function("collocation_jacobian", [z], [defects, ca.jacobian(defects, z)]),
        ca.Function("collocation_hessian", [z, multiplier], [hessian]),
    ]


def _roll_defects(layout: Layout, z: ca.SX, step: int) -> list[ca.SX]:
    rows = []
    interval = z[layout.time_index(step)] / layout.intervals
    for k in range(0, layout.nodes - 1, 2):
        first = layout.roll_index(step, k)
        a, m, b = (z[first + ROLL_STATES * j : first + ROLL_STATES * (j + 1)] for j in range(3))
        for i in range(2):
            rows.append(m[i] - (a[i] + b[i]) / 2 - interval / 8 * (a[i + 1] - b[i + 1]))
            mean = (a[i + 1] + 4 * m[i + 1] + b[i + 1]) / 6
            rows.append(b[i] - a[i] - interval * mean)
    return rows
