"""Symbolic functions of a node, of the step ends and of the collocation, with exact derivatives."""

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from slider.gait.constraint import Constraint
from slider.gait.formulation import Formulation
from slider.gait.layout import END, NODE, ROLL_STATES, STEP, Layout
from slider.gait.symbols import StepEnd
from slider.gait.tree import NUM_JOINTS


@dataclass(frozen=True)
class Piece:
    """A symbolic function with first and second derivatives."""

    value: ca.Function
    jacobian: ca.Function
    hessian: ca.Function


def node_piece(form: Formulation) -> tuple[Piece, ca.Function, list[Constraint]]:
    """Cost and constraints of a node, the cost's gradient, and the constraints.

    ``value``: (x, weight) → cost, rows; ``jacobian``: x → rows, their Jacobian; ``hessian``:
    (x, weight, factor, multipliers) → symmetric (34, 34).
    """
    x, weight = ca.SX.sym("x", NODE), ca.SX.sym("w")
    constraints, cost = form.node(x, weight)
    rows = _scaled(constraints)
    multiplier, factor = ca.SX.sym("lam", rows.numel()), ca.SX.sym("f")
    hessian, _ = ca.hessian(factor * cost + ca.dot(multiplier, rows), x)
    full = ca.triu2symm(ca.triu(hessian))
    gradient = ca.Function("cost", [x, weight], [cost, ca.gradient(cost, x)])
    piece = Piece(
        ca.Function("node", [x, weight], [cost, rows]),
        ca.Function("node_jacobian", [x], [rows, ca.jacobian(rows, x)]),
        ca.Function("node_hessian", [x, weight, factor, multiplier], [full]),
    )
    return piece, gradient, constraints


def quantities(form: Formulation) -> ca.Function:
    """What a gait stores of a node; see ``Formulation.quantities``."""
    x = ca.SX.sym("x", NODE)
    return ca.Function("quantities", [x], form.quantities(x))


def ends_piece(form: Formulation) -> tuple[Piece, list[Constraint]]:
    """Touchdowns and periodicity as functions of the step ends (90,) and the command (2,)."""
    y, velocity = ca.SX.sym("y", 2 * STEP), ca.SX.sym("p", 2)
    constraints = _connect(form, y, velocity)
    rows = _scaled(constraints)
    multiplier = ca.SX.sym("lam", rows.numel())
    hessian, _ = ca.hessian(ca.dot(multiplier, rows), y)
    full = ca.triu2symm(ca.triu(hessian))
    piece = Piece(
        ca.Function("ends", [y, velocity], [rows]),
        ca.Function("ends_jacobian", [y, velocity], [rows, ca.jacobian(rows, y)]),
        ca.Function("ends_hessian", [y, velocity, multiplier], [full]),
    )
    return piece, constraints


def _connect(form: Formulation, y: ca.SX, velocity: ca.SX) -> list[Constraint]:
    """Touchdowns of both steps, mean velocity, equal step times and forward step lengths.

    Without equal lengths the cheapest slow walk keeps one foot 0.4 m ahead of the other.
    """
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


def _step_end(part: ca.SX, step_time: ca.SX) -> StepEnd:
    n = NUM_JOINTS
    return StepEnd(part[0], part[1], part[2 : 2 + n], part[2 + n :] / step_time)


def _symmetry(name: str, unit: str, difference: ca.SX, scale: float) -> Constraint:
    zero = np.zeros(1)
    return Constraint(name, unit, "symmetry", difference, zero, zero, scale)


def collocation_piece(layout: Layout) -> Piece:
    """Hermite-Simpson defects, separated form, of roll, roll rate and collocated joints."""
    z = ca.SX.sym("z", layout.size)
    rolls = [row for step in range(2) for row in _roll_defects(layout, z, step)]
    defects = ca.vertcat(*rolls, ca.mtimes(ca.DM(layout.joint_defects), z))
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


def _scaled(constraints: Sequence[Constraint]) -> ca.SX:
    return ca.vertcat(*[c.expression / c.scale for c in constraints])
