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


def node_piece(form: Formulation) -> tuple[Piece, ca.Function, list[Constraint]]:
    """Cost and constraints of a node, the cost's gradient, and the constraints.

    ``value``: (x, weight, turn) → cost, rows; ``jacobian``: (x, turn) → rows, their Jacobian;
    ``hessian``: (x, weight, turn, factor, multipliers) → symmetric (34, 34). ``turn`` (2,) is what
    ``Node.of`` says.
    """
    x, weight, turn = ca.SX.sym("x", NODE), ca.SX.sym("w"), ca.SX.sym("turn", 2)
    node = Node.of(form, x, turn)
    rows_of, cost = constraints.of_node(node), COSTS[form.config.cost]
    rows, cost = scaled_rows(rows_of), cost.scale * cost.node(node, weight)
    multiplier, factor = ca.SX.sym("lam", rows.numel()), ca.SX.sym("f")
    hessian, _ = ca.hessian(factor * cost + ca.dot(multiplier, rows), x)
    full = ca.triu2symm(ca.triu(hessian))
    gradient = ca.Function("cost", [x, weight], [cost, ca.gradient(cost, x)])
    piece = Piece(
        ca.Function("node", [x, weight, turn], [cost, rows]),
        ca.Function("node_jacobian", [x, turn], [rows, ca.jacobian(rows, x)]),
        ca.Function("node_hessian", [x, weight, turn, factor, multiplier], [full]),
    )
    return piece, gradient, rows_of


def quantities(form: Formulation) -> ca.Function:
    """What a gait stores of a node; see ``Node.stored``."""
    x = ca.SX.sym("x", NODE)
    return ca.Function("quantities", [x], Node.of(form, x, ca.SX(2, 1)).stored())


def ends_piece(form: Formulation) -> tuple[Piece, list[Constraint]]:
    """Touchdowns and periodicity as functions of the step ends (90,) and the command (3,)."""
    y, command = ca.SX.sym("y", 2 * STEP), ca.SX.sym("p", len(COMMAND))
    rows_of = _walk(form, y, command)
    rows = scaled_rows(rows_of)
    multiplier = ca.SX.sym("lam", rows.numel())
    hessian, _ = ca.hessian(ca.dot(multiplier, rows), y)
    full = ca.triu2symm(ca.triu(hessian))
    piece = Piece(
        ca.Function("ends", [y, command], [rows]),
        ca.Function("ends_jacobian", [y, command], [rows, ca.jacobian(rows, y)]),
        ca.Function("ends_hessian", [y, command, multiplier], [full]),
    )
    return piece, rows_of


def _walk(form: Formulation, y: ca.SX, command: ca.SX) -> list[Constraint]:
    steps = [y[step * STEP : (step + 1) * STEP] for step in range(2)]
    times = [step[-1] for step in steps]
    starts = [_step_end(step[:END], step[-1]) for step in steps]
    ends = [_step_end(step[END : 2 * END], step[-1]) for step in steps]
    return constraints.of_walk(form, starts, ends, times, command)


def _step_end(part: ca.SX, step_time: ca.SX) -> StepEnd:
    n = NUM_JOINTS
    return StepEnd(part[0], part[1], part[2 : 2 + n], part[2 + n :] / step_time)


def collocation_piece(layout: Layout) -> Piece:
    """Hermite-Simpson defects, separated form, of roll, roll rate and collocated joints."""
    z = ca.SX.sym("z", layout.size)
    rolls = [row for step in range(2) for row in _roll_defects(layout, z, step)]
    defects = ca.vertcat(*rolls, ca.mtimes(layout.joint_defects, z))
    multiplier = ca.SX.sym("lam", defects.numel())
    hessian, _ = ca.hessian(ca.dot(multiplier, defects), z)
    return Piece(
        ca.Function("collocation", [z], [defects]),
        ca.Function("collocation_jacobian", [z], [defects, ca.jacobian(defects, z)]),
        ca.Function("collocation_hessian", [z, multiplier], [hessian]),
    )


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
