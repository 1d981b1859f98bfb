"""Problems and solved gaits that several tests share."""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from slider.core.config.compose import compose
from slider.core.config.convert import to_dict
from slider.core.config.schema import Config
from slider.gait.formulation import Formulation
from slider.gait.layout import NODE
from slider.gait.problem import GaitProblem, build
from slider.gait.solution import KneeTrajectory, knee_trajectory
from slider.gait.solve import GaitSolver, Solve
from slider.gait.tree import StanceTree
from slider.robot.knee_model import KneeModel, build_knee_model

CONF = Path(__file__).parents[2] / "conf"
ROBOT_PARTS = ("geometry", "links", "virtual_knee", "limits", "capstan")
SOLVE_PARTS = ("kinematic_map", "step_time", "solver")


@cache
def config() -> Config:
    return compose([], CONF)


@cache
def model() -> KneeModel:
    robot = config().robot
    return build_knee_model(robot.geometry, robot.links, robot.virtual_knee)


@cache
def form() -> Formulation:
    robot = config().robot
    length = robot.geometry.leg_length
    tree = StanceTree(model())
    return Formulation(tree, config().gait, robot.limits, robot.capstan, length)


@cache
def problem() -> GaitProblem:
    return build(form())


@cache
def solver() -> GaitSolver:
    return GaitSolver(problem(), config().gait.solver, config().gait.step_time)


@cache
def solved(vx: float, vy: float) -> Solve:
    return solver().solve(vx, vy)


@cache
def trajectory(vx: float, vy: float) -> KneeTrajectory:
    return knee_trajectory(problem(), solved(vx, vy).variables)


def nodes(vx: float, vy: float) -> np.ndarray:
    """Node vectors (42, 34) of a solved gait; the second step is reflected."""
    return (problem().layout.select_nodes @ solved(vx, vy).variables).reshape(-1, NODE)


def section(vx: float, vy: float, **solver_settings: Any) -> dict[str, Any]:
    """What the stage ``gait`` gets."""
    values = to_dict(config())
    gait = {key: value for key, value in values["gait"].items() if key != "grid"}
    solve = {name: gait.pop(name) for name in SOLVE_PARTS}
    solve["solver"] = {**solve["solver"], **solver_settings}
    robot = {name: values["robot"][name] for name in ROBOT_PARTS}
    return {"robot": robot, "formulation": gait, "solve": solve, "velocity": [vx, vy]}
