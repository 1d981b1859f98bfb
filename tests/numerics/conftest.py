"""A real gait, solved once, in both coordinate systems."""

from dataclasses import dataclass
from pathlib import Path

import pytest

from slider.config.compose import compose
from slider.gait.formulation import Formulation, formulate
from slider.gait.problem import GaitProblem, build
from slider.gait.solution import KneeTrajectory, knee_trajectory
from slider.gait.solve import GaitSolver, Solve

CONF = Path(__file__).parents[2] / "conf"


@pytest.fixture(scope="session")
def config():
    return compose([], CONF)


@pytest.fixture(scope="session")
def formulation(config) -> Formulation:
    return formulate(config.robot, config.gait)


@dataclass(frozen=True)
class SolvedGait:
    """A gait with its problem and its samples."""

    problem: GaitProblem
    solve: Solve
    trajectory: KneeTrajectory


@pytest.fixture(scope="session")
def solver(config, formulation) -> GaitSolver:
    return GaitSolver(build(formulation), config.gait.solver, config.gait.step_time)


@pytest.fixture(scope="session")
def solved(solver) -> SolvedGait:
    solve = solver.solve(0.6, 0.05)
    assert solve.success, solve.status
    return SolvedGait(solver.problem, solve, knee_trajectory(solver.problem, solve.variables))
