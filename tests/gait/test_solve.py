"""Gaits over the range of velocities, and with the hip as the phase: they converge and walk."""

from dataclasses import replace
from functools import cache

import pytest

from slider.gait.formulation import Formulation, least_hip_rate
from slider.gait.problem import build
from slider.gait.solution import dense_violations, knee_trajectory
from slider.gait.solve import GaitSolver, Solve
from tests.gait.gaits import config, form, problem, solved

VELOCITIES = [(0.0, 0.0), (0.4, -0.1), (1.2, 0.0), (2.2, 0.1)]


@pytest.mark.parametrize("velocity", VELOCITIES)
def test_cold_starts_converge(velocity):
    solve = solved(*velocity)
    assert solve.success, solve.status
    assert solve.max_violation <= 1e-6
    assert solve.iterations < 60


VELOCITY = (0.6, 0.0)
SHARE = 0.97


@cache
def solver(share: float, vx: float) -> GaitSolver:
    gait = replace(config().gait, phase="hip", hip_share=share)
    bounded = Formulation(config().robot, gait, hip_rate=least_hip_rate(gait, vx))
    return GaitSolver(build(bounded), gait.solver, gait.step_time)


def least_speed(solver: GaitSolver, solve: Solve) -> float:
    """Forward velocity of the hip [m/s]."""
    return float(knee_trajectory(solver.problem, solve.variables).base_velocity[:, 0].min())


def test_a_bound_that_bites_is_kept_and_so_are_the_others():
    hip = solver(SHARE, VELOCITY[0])
    solve = hip.solve(*VELOCITY)
    assert solve.success, solve.status
    assert set(solve.residuals) == set(solved(*VELOCITY).residuals) | {"hip_rate"}
    assert solve.max_violation <= config().library.max_violation
    free = knee_trajectory(problem(), solved(*VELOCITY).variables).base_velocity[:, 0].min()
    assert free < 0.95 * VELOCITY[0]
    assert least_speed(hip, solve) == pytest.approx(SHARE * VELOCITY[0], abs=1e-6)
    assert solve.cost > solved(*VELOCITY).cost
    assert dense_violations(hip.problem, solve.variables)["hip_rate"] < 5e-3


def test_slow_gaits_have_no_bound():
    hip = solver(1.0, 0.2)
    solve = hip.solve(0.2, 0.0)
    assert solve.success, solve.status
    assert not hip.problem.form.by_hip
    assert least_speed(hip, solve) < 0.2
    assert solve.residuals["hip_rate"] == 0.0


def test_functions_depend_on_the_formulation_but_not_on_how_great_the_bound_is():
    hip, robot = replace(config().gait, phase="hip"), config().robot
    forms = [Formulation(robot, hip, hip_rate=rate) for rate in (1.0, 2.0, 0.0)]
    forms += [form(), form(turning=True), form("knee")]
    facts = [each.facts for each in forms]
    assert facts[0] == facts[1]
    assert all(facts[k] not in facts[:k] for k in range(2, len(facts)))
