"""Assemble a gait problem's pieces into functions for IPOPT."""

from dataclasses import dataclass

import casadi as ca

from slider.gait.layout import NODE
from slider.gait.problem import GaitProblem


@dataclass(frozen=True)
class Nlp:
    """Functions of the variables x and the command p = (vx, vy)."""

    objective_and_rows: ca.Function
    gradient: ca.Function
    jacobian: ca.Function
    hessian: ca.Function


def assemble(problem: GaitProblem) -> Nlp:
    """Map the node functions over all nodes and scatter their derivatives."""
    layout, count = problem.layout, 2 * problem.nodes
    x, p = ca.MX.sym("x", layout.size), ca.MX.sym("p", 2)
    select, select_ends = ca.DM(layout.select_nodes), ca.DM(layout.select_ends)
    nodes = ca.reshape(select @ x, NODE, count)
    ends = select_ends @ x
    weights = ca.DM(layout.weights).T

    costs, rows = problem.node.value.map(count)(nodes, weights)
    objective = ca.sum2(costs)
    stacked = ca.vertcat(ca.vec(rows), problem.collocation.value(x), problem.ends.value(ends, p))

    costs_again, slopes = problem.gradient.map(count)(nodes, weights)
    gradient = select.T @ ca.vec(slopes)

    node_rows, node_jacobians = problem.node.jacobian.map(count)(nodes)
    defects, defect_jacobian = problem.collocation.jacobian(x)
    end_rows, end_jacobian = problem.ends.jacobian(ends, p)
    jacobian = ca.vertcat(
        ca.diagcat(*ca.horzsplit(node_jacobians, NODE)) @ select,
        defect_jacobian,
        end_jacobian @ select_ends,
    )
    row_values = ca.vertcat(ca.vec(node_rows), defects, end_rows)

    factor, multipliers = ca.MX.sym("f"), ca.MX.sym("lam", stacked.numel())
    per_node, per_collocation, _ = problem.row_counts
    split = per_node * count
    node_hessians = problem.node.hessian.map(count)(
        nodes,
        weights,
        ca.repmat(factor, 1, count),
        ca.reshape(multipliers[:split], per_node, count),
    )
    hessian = select.T @ ca.diagcat(*ca.horzsplit(node_hessians, NODE)) @ select
    hessian += problem.collocation.hessian(x, multipliers[split : split + per_collocation])
    end_hessian = problem.ends.hessian(ends, p, multipliers[split + per_collocation :])
    hessian += select_ends.T @ end_hessian @ select_ends
    return Nlp(
        ca.Function("nlp", [x, p], [objective, stacked], ["x", "p"], ["f", "g"]),
        ca.Function(
            "nlp_grad_f", [x, p], [ca.sum2(costs_again), gradient], ["x", "p"], ["f", "grad_f_x"]
        ),
        ca.Function("nlp_jac_g", [x, p], [row_values, jacobian], ["x", "p"], ["g", "jac_g_x"]),
        ca.Function(
            "nlp_hess_l",
            [x, p, factor, multipliers],
            [ca.triu(hessian)],
            ["x", "p", "lam_f", "lam_g"],
            ["triu_hess_gamma_x_x"],
        ),
    )
