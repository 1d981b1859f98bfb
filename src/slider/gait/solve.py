"""Solve a gait problem for one commanded velocity."""

import time
from dataclasses import dataclass

import casadi as ca
import numpy as np

from slider.core.config.gait import SolverConfig
from slider.gait.guess import cold_start
from slider.gait.nlp import assemble
from slider.gait.problem import GaitProblem


@dataclass(frozen=True)
class Solve:
    """Outcome of one optimisation; a failure is an outcome too.

    Attributes:
        variables: (size,) best point found.
        status: IPOPT's return status.
        success: whether IPOPT reports convergence.
        iterations: of IPOPT.
        cost: in SI units.
        residuals: worst violation by constraint name, in the constraint's own unit.
        wall, cpu: time of the solve [s].
    """

    variables: np.ndarray
    status: str
    success: bool
    iterations: int
    cost: float
    residuals: dict[str, float]
    wall: float
    cpu: float

    @property
    def max_violation(self) -> float:
        """Worst residual over all constraints."""
        return max(self.residuals.values())


class GaitSolver:
    """IPOPT on one problem; reusable for several velocities."""

    def __init__(self, problem: GaitProblem) -> None:
        self.problem = problem
        self._nlp = assemble(problem)
        self._solver = self._build(problem.formulation.config.solver)

    def _build(self, config: SolverConfig) -> ca.Function:
        x, p = ca.MX.sym("x", self.problem.size), ca.MX.sym("p", 2)
        objective, rows = self._nlp.objective_and_rows(x, p)
        options = {
            "ipopt": {
                "max_iter": config.max_iterations,
                "tol": config.tolerance,
                "constr_viol_tol": config.constraint_tolerance,
                "linear_solver": "mumps",
                "mu_strategy": "adaptive",
                "acceptable_tol": 1e-4,
                "acceptable_iter": 15,
                "bound_relax_factor": 1e-9,
                "print_level": 0,
                "sb": "yes",
            },
            "print_time": False,
            "no_nlp_grad": True,
            "calc_lam_p": False,
            "grad_f": self._nlp.gradient,
            "jac_g": self._nlp.jacobian,
            "hess_lag": self._nlp.hessian,
            "error_on_fail": False,
        }
        return ca.nlpsol("gait", "ipopt", {"x": x, "p": p, "f": objective, "g": rows}, options)

    def solve(self, vx: float, vy: float) -> Solve:
        """Cold solve for a commanded velocity [m/s]."""
        lower, upper = self.problem.variable_bounds
        row_lower, row_upper = self.problem.row_bounds
        wall, cpu = time.perf_counter(), time.process_time()
        result = self._solver(
            x0=cold_start(self.problem, vx),
            p=[vx, vy],
            lbx=lower,
            ubx=upper,
            lbg=row_lower,
            ubg=row_upper,
        )
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        stats = self._solver.stats()
        variables = np.array(result["x"]).ravel()
        return Solve(
            variables=variables,
            status=str(stats["return_status"]),
            success=bool(stats["success"]),
            iterations=int(stats["iter_count"]),
            cost=float(result["f"]) / self.problem.cost_scale,
            residuals=self.residuals(np.array(result["g"]).ravel(), variables),
            wall=wall,
            cpu=cpu,
        )

    def residuals(self, rows: np.ndarray, variables: np.ndarray) -> dict[str, float]:
        """Worst violation by constraint name; constraints of both steps count together."""
        lower, upper = self.problem.row_bounds
        excess = np.maximum(np.maximum(lower - rows, rows - upper), 0.0)
        worst: dict[str, float] = {}
        for block in self.problem.blocks:
            value = float(excess[block.rows].max() * block.scale)
            worst[block.name] = max(worst.get(block.name, 0.0), value)
        low, high = self.problem.variable_bounds
        worst["variables"] = float(
            np.maximum(np.maximum(low - variables, variables - high), 0.0).max()
        )
        return worst
