"""Assemble a gait problem for IPOPT, and solve it for one velocity."""

import time
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from typing import NamedTuple

import casadi as ca
import numpy as np

from slider.config.gait import SolverConfig
from slider.config.types import Interval
from slider.gait.costs import COSTS
from slider.gait.guess import STARTS, cold_start
from slider.gait.problem import GaitProblem, worst_of
from slider.gait.transcription import NODE
from slider.robot.names import VELOCITY

GIVEN = "given"  # name of a start that is not one of the configured guesses
ANCHOR = "anchor"  # name of a start from the gait of another velocity
RAMP = (0.25, 0.5, 0.75, 1.0)  # shares of the velocity that are solved in turn
# No permutation, scaling by the diagonal, AMD: on these gaits the fastest of MUMPS's choices.
_MUMPS = {"mumps_permuting_scaling": 0, "mumps_scaling": 1, "mumps_pivot_order": 0}
# Return statuses of IPOPT that the problem determines. Others, such as those of an interrupted
# callback, a time limit or too little memory, depend on the machine.
_ENDS = {
    *("Solve_Succeeded", "Solved_To_Acceptable_Level", "Feasible_Point_Found"),
    *("Infeasible_Problem_Detected", "Maximum_Iterations_Exceeded", "Restoration_Failed"),
    *("Search_Direction_Becomes_Too_Small", "Diverging_Iterates", "Error_In_Step_Computation"),
    *("Invalid_Number_Detected", "Not_Enough_Degrees_Of_Freedom"),
}
_PUSHED = ("bound_push", "bound_frac", "slack_bound_push", "slack_bound_frac", "mult_bound_push")
# Start off the bounds: from nearer to them some gaits end in costlier optima than from a guess.
_WARM = {"warm_start_init_point": "yes"} | {f"warm_start_{name}": 3e-2 for name in _PUSHED}


class PrimalDual(NamedTuple):
    """Variables (size,), and multipliers (size + rows,) of their bounds and of the rows."""

    variables: np.ndarray
    multipliers: np.ndarray

    @classmethod
    def of(cls, result: dict[str, ca.DM]) -> "PrimalDual":
        """Variables and multipliers of a result of ``nlpsol``."""
        multipliers = ca.vertcat(result["lam_x"], result["lam_g"])
        return cls(result["x"].full().ravel(), multipliers.full().ravel())


@dataclass(frozen=True)
class Attempt:
    """A solve from one initial guess, for the report."""

    name: str
    status: str
    iterations: int
    cost: float


@dataclass(frozen=True)
class Solve:
    """Result of one optimisation, failed or not.

    Attributes:
        variables: (size,) best point found.
        status: IPOPT's return status.
        success: whether IPOPT reports convergence.
        iterations: of IPOPT, of the attempt that is the result.
        cost: in SI units.
        residuals: worst violation by constraint name, in the constraint's own unit.
        worst: the value of each residual and its bound, as text.
        cpu: processor time of all attempts [s].
        attempts: all attempts, in order.
        multipliers: see ``PrimalDual``.
    """

    variables: np.ndarray
    status: str
    success: bool
    iterations: int
    cost: float
    residuals: dict[str, float]
    worst: dict[str, str]
    cpu: float
    attempts: tuple[Attempt, ...] = ()
    multipliers: np.ndarray = field(default_factory=lambda: np.zeros(0))

    @property
    def max_violation(self) -> float:
        """Worst residual over all constraints."""
        return max(self.residuals.values())


class Nlp:
    """Functions of the variables x and the velocity p = (vx, vy, yaw rate), for IPOPT.

    The functions of a node are mapped over all nodes; constant matrices from x to the nodes and to
    the ends of the steps assemble their derivatives.
    """

    def __init__(self, problem: GaitProblem) -> None:
        layout, self._problem, self._count = problem.layout, problem, 2 * problem.layout.nodes
        self.x, self.p = ca.MX.sym("x", layout.size), ca.MX.sym("p", len(VELOCITY))
        self._select, self._select_ends = layout.select_nodes, layout.select_ends
        self._nodes = ca.reshape(self._select @ self.x, NODE, self._count)
        self._ends = self._select_ends @ self.x
        self._weights, turns = ca.DM(layout.weights).T, ca.DM(layout.turns)
        self._turns = ca.vertcat(self.p[2] * turns[0, :], turns[1, :])  # as Node has them

    @cached_property
    def objective_and_rows(self) -> ca.Function:
        """(x, p) → cost, rows."""
        functions = self._problem.functions
        at_nodes = functions["node"].map(self._count)
        costs, node_rows = at_nodes(self._nodes, self._weights, self._turns)
        defects = functions["collocation"](self.x)
        end_rows = functions["ends"](self._ends, self.p)
        results = [ca.sum2(costs), ca.vertcat(ca.vec(node_rows), defects, end_rows)]
        return ca.Function("nlp", [self.x, self.p], results, ["x", "p"], ["f", "g"])

    @cached_property
    def gradient(self) -> ca.Function:
        """(x, p) → cost, its gradient."""
        at_nodes = self._problem.functions["cost"].map(self._count)
        costs, slopes = at_nodes(self._nodes, self._weights)
        results = [ca.sum2(costs), self._select.T @ ca.vec(slopes)]
        names = ["f", "grad_f_x"]
        return ca.Function("nlp_grad_f", [self.x, self.p], results, ["x", "p"], names)

    @cached_property
    def jacobian(self) -> ca.Function:
        """(x, p) → rows, their Jacobian."""
        functions = self._problem.functions
        at_nodes = functions["node_jacobian"].map(self._count)
        node_rows, nodes = at_nodes(self._nodes, self._turns)
        defects, defect_jacobian = functions["collocation_jacobian"](self.x)
        end_rows, ends = functions["ends_jacobian"](self._ends, self.p)
        rows = ca.vertcat(ca.vec(node_rows), defects, end_rows)
        parts = [_diagonal(nodes) @ self._select, defect_jacobian, ends @ self._select_ends]
        results, names = [rows, ca.vertcat(*parts)], ["g", "jac_g_x"]
        return ca.Function("nlp_jac_g", [self.x, self.p], results, ["x", "p"], names)

    @cached_property
    def hessian(self) -> ca.Function:
        """(x, p, factor of the cost, multipliers) → upper triangle of the Lagrangian's Hessian."""
        functions, (per_node, collocation, ends) = self._problem.functions, self._problem.row_counts
        first, second = per_node * self._count, per_node * self._count + collocation
        factor, multipliers = ca.MX.sym("f"), ca.MX.sym("lam", second + ends)
        factors = ca.repmat(factor, 1, self._count)
        node_multipliers = ca.reshape(multipliers[:first], per_node, self._count)
        at_nodes = functions["node_hessian"].map(self._count)
        nodes = at_nodes(self._nodes, self._weights, self._turns, factors, node_multipliers)
        hessian = self._select.T @ _diagonal(nodes) @ self._select
        hessian += functions["collocation_hessian"](self.x, multipliers[first:second])
        at_ends = functions["ends_hessian"](self._ends, self.p, multipliers[second:])
        hessian += self._select_ends.T @ at_ends @ self._select_ends
        arguments, names = [self.x, self.p, factor, multipliers], ["x", "p", "lam_f", "lam_g"]
        results = [ca.triu(hessian)]
        return ca.Function("nlp_hess_l", arguments, results, names, ["triu_hess_gamma_x_x"])


def _diagonal(blocks: ca.MX) -> ca.MX:
    """Block-diagonal matrix of blocks side by side, one per node."""
    return ca.diagcat(*ca.horzsplit(blocks, NODE))


class GaitSolver:
    """IPOPT on one problem; reusable for several velocities."""

    def __init__(
        self, problem: GaitProblem, config: SolverConfig, step_time: Interval[float]
    ) -> None:
        self.problem = problem
        self._config, self._duration = config, (step_time.lower, step_time.upper)
        self._nlp = Nlp(problem)
        self._ipopt = cache(self._build)

    def _build(self, warm: bool) -> ca.Function:
        config, nlp = self._config, self._nlp
        ipopt = {
            "max_iter": config.max_iterations,
            "tol": config.tolerance,
            "constr_viol_tol": config.constraint_tolerance,
            "linear_solver": "mumps",
            **_MUMPS,
            "mu_strategy": "adaptive",
            "acceptable_tol": 1e-4,
            "acceptable_iter": 15,
            "bound_relax_factor": 1e-9,
            "print_level": 0,
            "sb": "yes",
            "option_file_name": "",  # else an ipopt.opt in the working directory changes the gait
        }
        options = {
            "ipopt": ipopt | (_WARM if warm else {}),
            "print_time": False,
            "no_nlp_grad": True,
            "calc_lam_p": False,
            "grad_f": nlp.gradient,
            "jac_g": nlp.jacobian,
            "hess_lag": nlp.hessian,
            "error_on_fail": False,
        }
        return ca.nlpsol("gait", "ipopt", nlp.objective_and_rows, options)

    def solve(
        self,
        vx: float,
        vy: float,
        yaw_rate: float = 0.0,
        start: np.ndarray | None = None,
        anchor: PrimalDual | None = None,
    ) -> Solve:
        """Solve for a velocity [m/s, rad/s], from an ``anchor``, if any, then from the guesses.

        The result is the first that converges, else the first of all. Variables ``start`` (size,)
        replace the guesses.

        Raises:
            ValueError: the yaw rate is not zero, and the formulation does not turn.
            RuntimeError: IPOPT ended for a reason outside of the problem.
        """
        if yaw_rate and not self.problem.form.turning:
            raise ValueError(f"expected a turning formulation for {yaw_rate} rad/s, found another")
        solves = list[Solve]()
        guesses = self._config.guesses if start is None else [start]
        for guess in guesses if anchor is None else [anchor, *guesses]:
            solves.append(self.attempt(guess, vx, vy, yaw_rate))
            if solves[-1].success:
                break
        return replace(
            solves[-1] if solves[-1].success else solves[0],
            cpu=sum(solve.cpu for solve in solves),
            attempts=tuple(attempt for solve in solves for attempt in solve.attempts),
        )

    def attempt(
        self, guess: str | np.ndarray | PrimalDual, vx: float, vy: float, yaw_rate: float = 0.0
    ) -> Solve:
        """Solve for a velocity [m/s, rad/s] from a named guess, variables or another optimum."""
        start = time.process_time()
        function, result = self._solve_from(guess, np.array([vx, vy, yaw_rate]))
        stats = function.stats()
        cost = float(result["f"]) / COSTS[self.problem.form.config.cost].scale
        status, iterations = str(stats["return_status"]), int(stats["iter_count"])
        (variables, multipliers), rows = PrimalDual.of(result), np.array(result["g"]).ravel()
        given = ANCHOR if isinstance(guess, PrimalDual) else GIVEN
        name = guess if isinstance(guess, str) else given
        worst = self._residuals(rows, variables)
        return Solve(
            variables=variables,
            status=status,
            success=bool(stats["success"]),
            iterations=iterations,
            cost=cost,
            residuals={name: beyond for name, (beyond, _) in worst.items()},
            worst={name: text for name, (_, text) in worst.items()},
            cpu=time.process_time() - start,
            attempts=(Attempt(name, status, iterations, cost),),
            multipliers=multipliers,
        )

    def _solve_from(
        self, guess: str | np.ndarray | PrimalDual, velocity: np.ndarray
    ) -> tuple[ca.Function, dict[str, ca.DM]]:
        """Solve from another optimum, given variables, a cold start, or a ``ramp`` of gaits."""
        if isinstance(guess, PrimalDual):
            of_bounds, of_rows = np.split(guess.multipliers, [len(guess.variables)])
            start = {"x0": guess.variables, "lam_x0": of_bounds, "lam_g0": of_rows}
            return self._ipopt(True), self._call(self._ipopt(True), velocity, **start)
        if isinstance(guess, str) and guess == "ramp":  # first in place, then faster and faster
            solved = self._solve_from("cold", np.zeros(len(VELOCITY)))
            for share in RAMP:
                solved = self._solve_from(PrimalDual.of(solved[1]), share * velocity)
            return solved
        if isinstance(guess, str):
            form, layout = self.problem.form, self.problem.layout
            vx = velocity[0] / form.leg_scale
            guess = cold_start(layout, form.robot, vx, self._duration, STARTS[guess])
        return self._ipopt(False), self._call(self._ipopt(False), velocity, x0=guess)

    def _call(
        self, function: ca.Function, velocity: np.ndarray, **start: np.ndarray
    ) -> dict[str, ca.DM]:
        lower, upper = self.problem.variable_bounds(self._duration)
        row_lower, row_upper = self.problem.row_bounds
        bounds = {"lbx": lower, "ubx": upper, "lbg": row_lower, "ubg": row_upper}
        result = function(p=velocity, **bounds, **start)
        if (status := function.stats()["return_status"]) not in _ENDS:
            raise RuntimeError(f"expected IPOPT to end by itself, found {status}")
        return result

    def _residuals(self, rows: np.ndarray, variables: np.ndarray) -> dict[str, tuple[float, str]]:
        """Worst violation by constraint name; constraints of both steps count together."""
        lower, upper = self.problem.row_bounds
        worst: dict[str, tuple[float, str]] = {}
        for block in self.problem.blocks:
            at = block.rows
            violation = worst_of(rows[at], lower[at], upper[at], block.scale)
            worst[block.name] = max(worst.setdefault(block.name, violation), violation)
        worst["variables"] = worst_of(variables, *self.problem.variable_bounds(self._duration))
        return worst
