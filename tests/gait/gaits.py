"""Problems and solved gaits that several tests share."""

from dataclasses import replace
from functools import cache
from typing import Any

import casadi as ca
import numpy as np

from pipeline.stages.gaits import gait_section
from slider.config.schema import Config
from slider.gait.formulation import Formulation, NodeSymbols
from slider.gait.problem import GaitProblem, build
from slider.gait.solve import GaitSolver, Solve
from slider.gait.transcription import NODE
from tests import shared
from tests.config.composed import composed

STEP_TIME = "gait.step_time.upper=0.42"  # that of the gaits whose numbers the tests have


@cache
def config() -> Config:
    return composed(STEP_TIME)


@cache
def form(dynamics: str = "prismatic", turning: bool = False) -> Formulation:
    return Formulation(config().robot, replace(config().gait, dynamics=dynamics), turning)


@cache
def problem(turning: bool = False) -> GaitProblem:
    return build(form(turning=turning))


@cache
def solver(turning: bool = False) -> GaitSolver:
    return GaitSolver(problem(turning), config().gait.solver, config().gait.step_time)


@shared.shared
def solved(vx: float, vy: float, yaw_rate: float = 0.0) -> Solve:
    return solver(yaw_rate != 0.0).solve(vx, vy, yaw_rate)


def nodes(vx: float, vy: float) -> np.ndarray:
    """Node vectors (42, 34) of a solved gait; the second step is reflected."""
    return problem().layout.node_vectors(solved(vx, vy).variables).reshape(-1, NODE)


def inverse_dynamics(form: Formulation) -> ca.Function:
    """Torques, efforts, ground force and moment of a node vector (34,)."""
    x = ca.SX.sym("x", NODE)
    s, tree = NodeSymbols.of(x), form.tree
    found = tree.inverse_dynamics(s.roll, s.roll_rate, s.roll_acceleration, s.q, s.v, s.a)
    results = [found.torques, found.efforts, *tree.ground_wrench(s.roll, found)]
    return ca.Function("inverse_dynamics", [x], results)


def section(vx: float, vy: float, yaw_rate: float = 0.0, **solver_settings: Any) -> dict[str, Any]:
    """What the stage ``gait`` gets."""
    common = gait_section(config())
    solve = common["solve"] | {"solver": common["solve"]["solver"] | solver_settings}
    return common | {"solve": solve, "velocity": [vx, vy, yaw_rate]}
