"""Assemble a gait problem's pieces into functions for IPOPT."""

from dataclasses import dataclass

import casadi as ca

from slider.gait.problem import GaitProblem
from slider.gait.transcription import NODE
from slider.robot.names import VELOCITY


@dataclass(frozen=True)
class Nlp:
    """Functions of the variables x and the velocity p = (vx, vy, yaw rate)."""

    objective_and_rows: ca.Function
    gradient: ca.Function
    jacobian: ca.Function
    hessian: ca.Function


@dataclass(frozen=True)
class _Symbols:
    """Variables x, velocity p, and the arguments of the pieces.

    Attributes:
        select, select_ends: constant matrices from x to all nodes and to the ends of the steps.
        nodes: arguments of the node functions, a column per node; ``count`` of them.
        ends: arguments of the functions of the step ends.
        weights: of the nodes' costs, a row.
        turns: of the nodes (2, count); see ``Node.of``.
    """

    x: ca.MX
    p: ca.MX
    select: ca.DM
    select_ends: ca.DM
    nodes: ca.MX
    ends: ca.MX
    weights: ca.DM
    turns: ca.MX
    count: int


def assemble(problem: GaitProblem) -> Nlp:
    """Map the node functions over all nodes and scatter their derivatives."""
    symbols = _symbols(problem)
    return Nlp(
        _objective_and_rows(problem, symbols),
        _gradient(problem, symbols),
        _jacobian(problem, symbols),
        _hessian(problem, symbols),
    )


def _symbols(problem: GaitProblem) -> _Symbols:
    layout, count = problem.layout, 2 * problem.nodes
    x, p = ca.MX.sym("x", layout.size), ca.MX.sym("p", len(VELOCITY))
    select, select_ends = layout.select_nodes, layout.select_ends
    nodes = ca.reshape(select @ x, NODE, count)
    weights, turns = ca.DM(layout.weights).T, ca.DM(layout.turns)
    turns = ca.vertcat(p[2] * turns[0, :], turns[1, :])
    return _Symbols(x, p, select, select_ends, nodes, select_ends @ x, weights, turns, count)


def _objective_and_rows(problem: GaitProblem, s: _Symbols) -> ca.Function:
    costs, node_rows = problem.node.value.map(s.count)(s.nodes, s.weights, s.turns)
    defects, end_rows = problem.collocation.value(s.x), problem.ends.value(s.ends, s.p)
    rows = ca.vertcat(ca.vec(node_rows), defects, end_rows)
    return ca.Function("nlp", [s.x, s.p], [ca.sum2(costs), rows], ["x", "p"], ["f", "g"])


def _gradient(problem: GaitProblem, s: _Symbols) -> ca.Function:
    costs, slopes = problem.gradient.map(s.count)(s.nodes, s.weights)
    results = [ca.sum2(costs), s.select.T @ ca.vec(slopes)]
    return ca.Function("nlp_grad_f", [s.x, s.p], results, ["x", "p"], ["f", "grad_f_x"])


def _jacobian(problem: GaitProblem, s: _Symbols) -> ca.Function:
    node_rows, node_jacobians = problem.node.jacobian.map(s.count)(s.nodes, s.turns)
    defects, defect_jacobian = problem.collocation.jacobian(s.x)
    end_rows, end_jacobian = problem.ends.jacobian(s.ends, s.p)
    rows = ca.vertcat(ca.vec(node_rows), defects, end_rows)
    jacobian = ca.vertcat(
        _diagonal(node_jacobians) @ s.select,
        defect_jacobian,
        end_jacobian @ s.select_ends,
    )
    return ca.Function("nlp_jac_g", [s.x, s.p], [rows, jacobian], ["x", "p"], ["g", "jac_g_x"])


def _hessian(problem: GaitProblem, s: _Symbols) -> ca.Function:
    """Upper triangle of the Lagrangian's Hessian, with a factor before the objective."""
    per_node, collocation, ends = problem.row_counts
    split = per_node * s.count, per_node * s.count + collocation
    factor, multipliers = ca.MX.sym("f"), ca.MX.sym("lam", split[1] + ends)
    factors = ca.repmat(factor, 1, s.count)
    node_multipliers = ca.reshape(multipliers[: split[0]], per_node, s.count)
    arguments = s.nodes, s.weights, s.turns, factors, node_multipliers
    nodes = problem.node.hessian.map(s.count)(*arguments)
    hessian = s.select.T @ _diagonal(nodes) @ s.select
    hessian += problem.collocation.hessian(s.x, multipliers[split[0] : split[1]])
    at_ends = problem.ends.hessian(s.ends, s.p, multipliers[split[1] :])
    hessian += s.select_ends.T @ at_ends @ s.select_ends
    return ca.Function(
        "nlp_hess_l",
        [s.x, s.p, factor, multipliers],
        [ca.triu(hessian)],
        ["x", "p", "lam_f", "lam_g"],
        ["triu_hess_gamma_x_x"],
    )


def _diagonal(blocks: ca.MX) -> ca.MX:
    """Block-diagonal matrix of blocks side by side, one per node."""
    return ca.diagcat(*ca.horzsplit(blocks, NODE))
