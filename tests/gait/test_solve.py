"""Solved gaits: velocities, costs, step times, guesses and motors."""

import signal
import sys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from slider.config.types import Interval
from slider.gait.constraints import joint_bounds
from slider.gait.formulation import Formulation
from slider.gait.problem import GaitProblem, build
from slider.gait.solution import dense_nodes, dense_violations, knee_trajectory
from slider.gait.solve import GaitSolver, Solve
from slider.robot.knee_map import all_joints, prismatic_joints
from slider.robot.transmission import Transmission
from tests.gait.gaits import config, form, nodes, problem, solved
from tests.robot.lopsided import kneed

VELOCITY = (0.4, 0.0)


def formulated(**changes: Any) -> Formulation:
    return Formulation(config().robot, replace(config().gait, **changes))


def solver_of(gait: GaitProblem, guess: str = "cold", step_time: Interval | None = None):
    settings = replace(config().gait.solver, guesses=[guess])
    return GaitSolver(gait, settings, step_time or config().gait.step_time)


def test_a_solve_that_does_not_end_by_itself_is_no_result():
    """CasADi swallows what a handler raises, and IPOPT reports that it was stopped."""
    solver = solver_of(problem())
    solver._ipopt(False)
    before = signal.signal(signal.SIGVTALRM, lambda *_: sys.exit(1))
    signal.setitimer(signal.ITIMER_VIRTUAL, 0.1)
    try:
        with pytest.raises(RuntimeError, match="expected IPOPT to end by itself, found NonIpopt_"):
            solver.solve(*VELOCITY)
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, before)


def motors(variables: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Torques [N m] and speeds [rad/s] (S, 10) of the motors of a walk."""
    walk = knee_trajectory(problem(), variables)
    _, velocity = prismatic_joints(walk.q, walk.v, config().robot)
    transmission = Transmission.of(config().robot)
    return transmission.torques(all_joints(walk.efforts)), transmission.angles(velocity)


def test_each_cost_is_least_for_its_own_optimum():
    transport = solver_of(build(formulated(cost="transport"))).solve(*VELOCITY)
    found = {"paper": solved(*VELOCITY), "transport": transport}
    for name, own in found.items():
        assert own.success, name
        value = cost_of(name, own.variables)
        assert value == pytest.approx(own.cost, rel=1e-9)
        for other in found.values():
            assert value <= cost_of(name, other.variables) * (1 + 1e-6)


def cost_of(name: str, variables: np.ndarray) -> float:
    """Independent evaluation at the nodes."""
    gait = problem()
    layout = gait.layout
    trajectory = knee_trajectory(gait, variables)
    time = variables[layout.time_index(0)]
    square = (trajectory.torques**2).sum(axis=1)
    if name == "paper":
        return float(square.sum() / time)
    if name == "torque":
        return float(layout.weights @ square)
    torques, speeds = motors(variables)
    absolute = (np.sqrt((torques * speeds) ** 2 + 1.0) - 1.0).sum(axis=1)
    return float(layout.weights @ absolute) / 2 / (form().weight)


def test_the_ramp_arrives_where_the_cold_start_does():
    ramp = solver_of(problem(), "ramp").solve(*VELOCITY)
    assert [attempt.name for attempt in ramp.attempts] == ["ramp"]
    assert ramp.success
    assert ramp.cost == pytest.approx(solved(*VELOCITY).cost, rel=1e-6)


def test_a_step_time_that_is_given_is_kept():
    solver = solver_of(problem(), step_time=Interval(0.36, 0.36))
    solve, layout = solver.solve(*VELOCITY), solver.problem.layout
    assert solve.success
    assert [solve.variables[layout.time_index(step)] for step in range(2)] == [0.36, 0.36]


def test_weaker_motors_and_a_lower_voltage_reach_their_bounds():
    """Torques of the capstan's motors follow from slide force and ankle torque."""
    robot, limit, share = config().robot, 2.7, 0.25
    drive = replace(robot.drives["capstan"], torque=limit)
    weak = Formulation(replace(robot, drives=robot.drives | {"capstan": drive}), config().gait)
    transmission = Transmission.of(robot)

    def torque(solve: Solve) -> float:
        return np.abs(motors(solve.variables)[0][:, [3, 4, 8, 9]]).max()

    def voltage(solve: Solve) -> float:
        torques, speeds = motors(solve.variables)
        return np.abs(torques / transmission.stall + speeds / transmission.speed).max()

    low = formulated(voltage=share)
    for changed, quantity, bound in ((weak, torque, limit), (low, voltage, share)):
        solve = solver_of(build(changed)).solve(*VELOCITY)
        assert solve.success, solve.status
        assert quantity(solved(*VELOCITY)) > 1.02 * bound
        assert quantity(solve) == pytest.approx(bound, abs=1e-4)


def test_between_nodes_the_constraints_nearly_hold():
    violations = dense_violations(problem(), solved(*VELOCITY).variables)
    assert violations["clearance"] < 4e-4  # the nodes leave a margin below; nothing above
    assert violations["motor_torque"] == violations["motor_voltage"] == 0.0
    assert 0.1 < violations["foot_line_moment"] < 1.0
    assert violations["torso"] < 1e-3


def test_dense_phases_pass_through_the_nodes():
    phase = problem().layout.phase
    dense = dense_nodes(problem(), solved(*VELOCITY).variables, phase)
    np.testing.assert_allclose(dense, nodes(*VELOCITY), atol=1e-9)


@pytest.mark.parametrize("velocity", [(0.0, 0.0), (2.2, 0.1)])
def test_cold_starts_converge(velocity):
    solve = solved(*velocity)
    assert solve.success, solve.status
    assert solve.max_violation <= 1e-6
    assert solve.iterations < 60


@pytest.mark.parametrize("name", ["unitree_h1", "slider"])
def test_legs_without_a_virtual_knee_walk_in_their_own_coordinates(name):
    """A knee's flexion counts from straight, within ``gait.posture``; a slide has its range."""
    has_knee = name != "slider"
    robot = kneed(name) if has_knee else replace(config().robot, virtual_knee=None)
    posture = replace(config().gait.posture, foot_separation_max=1.0, swing_height=0.2)
    gait = build(Formulation(robot, replace(config().gait, posture=posture)))
    solve = GaitSolver(gait, config().gait.solver, config().gait.step_time).solve(0.4, 0.0)
    assert solve.success
    assert solve.max_violation <= 1e-6
    q, slide = knee_trajectory(gait, solve.variables).q, robot.joints["slide"]
    lower, upper = (posture.knee_min, posture.knee_max) if has_knee else (slide.lower, slide.upper)
    extension = q[:, [3, 8]] + robot.geometry.bend
    assert has_knee or joint_bounds(gait.form)[1][3] == pytest.approx(slide.upper)
    assert lower - 1e-6 <= extension.min() < extension.max() <= upper
    np.testing.assert_array_equal(prismatic_joints(q, q, robot)[0], all_joints(q))


def test_functions_depend_on_the_formulation():
    parameters = [each.parameters for each in (form(), form(turning=True), form("knee"))]
    assert all(parameters[k] not in parameters[:k] for k in range(len(parameters)))
