"""Solved gaits: velocities, transcriptions, costs, step-time laws, guesses, motors and the hip."""

import signal
import sys
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from slider.config.gait import StepTime
from slider.gait import bezier
from slider.gait.constraints import joint_bounds
from slider.gait.formulation import Formulation, least_hip_rate
from slider.gait.problem import build
from slider.gait.solution import coefficients, dense_nodes, dense_violations, knee_trajectory
from slider.gait.solve import Attempt, GaitSolver, Solve, duration_bounds
from slider.robot.knee_map import prismatic_joints, with_upper_feet
from slider.robot.transmission import Transmission
from tests.gait.gaits import config, form, nodes, problem, solved
from tests.robot.lopsided import kneed

VELOCITY = (0.4, 0.0)


@cache
def formulated(vx: float = VELOCITY[0], **changes: Any) -> Formulation:
    gait = replace(config().gait, **changes)
    return Formulation(config().robot, gait, hip_rate=least_hip_rate(gait, vx))


def solve_with(form: Formulation, guesses=("cold",), step_time: StepTime | None = None):
    gait = config().gait
    settings = replace(gait.solver, guesses=list(guesses))
    return GaitSolver(build(form), settings, step_time or gait.step_time)


def test_a_solve_that_does_not_end_by_itself_is_no_result():
    """CasADi swallows what a handler raises, and IPOPT reports that it was stopped."""
    solver = solve_with(form())
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
    return transmission.torques(with_upper_feet(walk.efforts)), transmission.angles(velocity)


def test_collocation_costs_less_than_polynomials():
    """The polynomials are a subset of all motions, up to the collocation's own error."""
    solver = solve_with(formulated(transcription="collocation"))
    free = solver.solve(*VELOCITY)
    assert free.success, free.status
    assert free.max_violation <= 1e-6
    assert 0.2 < free.cost / solved(*VELOCITY).cost < 0.4
    fitted, error = coefficients(solver.problem, free.variables)
    assert fitted.shape == (2, 10, config().gait.degree + 1)
    assert 0.01 < error < 0.1
    positions = solver.problem.layout.node_vectors(free.variables)[..., 3:13]
    phase = solver.problem.layout.phase
    missed = [bezier.evaluate(fitted[step], phase) - positions[step] for step in range(2)]
    assert np.abs(missed).max() == pytest.approx(error, rel=1e-9)


def test_each_cost_is_least_for_its_own_optimum():
    found = {
        name: solve_with(formulated(cost=name)).solve(*VELOCITY) for name in ("torque", "transport")
    }
    found["paper"] = solved(*VELOCITY)
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
    ramp = solve_with(formulated(), guesses=("ramp",)).solve(*VELOCITY)
    assert [attempt.name for attempt in ramp.attempts] == ["ramp"]
    assert ramp.success
    assert ramp.cost == pytest.approx(solved(*VELOCITY).cost, rel=1e-6)


ENDS = {"fast": (1.0, False), "cold": (3.0, True), "crouched": (2.0, True)}


class Scripted(GaitSolver):
    """Attempts end as given: cost and success by guess."""

    def attempt(self, guess: str, vx: float, vy: float, yaw_rate: float = 0.0) -> Solve:
        cost, success = ENDS[guess]
        attempts = (Attempt(guess, "", 1, cost),)
        return Solve(np.full(3, cost), "", success, 1, cost, {}, {}, 0.0, 0.0, {}, attempts)


@pytest.mark.parametrize(
    ("keep", "guesses", "cost", "tried"),
    [
        ("first", ["cold", "crouched"], 3.0, 1),
        ("first", ["fast", "cold", "crouched"], 3.0, 2),
        ("best", ["fast", "cold", "crouched"], 2.0, 3),
        ("best", ["fast"], 1.0, 1),
    ],
)
def test_the_first_or_the_best_success_is_kept(keep, guesses, cost, tried):
    settings = replace(config().gait.solver, guesses=guesses, keep=keep)
    solve = Scripted(problem(), settings, config().gait.step_time).solve(*VELOCITY)
    assert (solve.cost, solve.success) == (cost, ENDS[guesses[tried - 1]][1])
    assert [attempt.name for attempt in solve.attempts] == guesses[:tried]
    assert (solve.variables == cost).all()


def test_step_time_laws():
    laws = {"free": (0.25, 0.42), "fixed": (0.4, 0.4), "speed": (0.35, 0.35)}
    for law, expected in laws.items():
        bounds = duration_bounds(StepTime(0.25, 0.42, law, 0.4, -0.05), 1.0, 0.0)
        assert bounds == pytest.approx(expected)
    solver = solve_with(formulated(), step_time=StepTime(0.25, 0.42, "fixed", 0.36, 0.0))
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

    for changed, quantity, bound in (
        (weak, torque, limit),
        (formulated(voltage=share), voltage, share),
    ):
        solve = solve_with(changed).solve(*VELOCITY)
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


@pytest.mark.parametrize("velocity", [(0.0, 0.0), (0.4, -0.1), (1.2, 0.0), (2.2, 0.1)])
def test_cold_starts_converge(velocity):
    solve = solved(*velocity)
    assert solve.success, solve.status
    assert solve.max_violation <= 1e-6
    assert solve.iterations < 60


@pytest.mark.parametrize("name", ["unitree_h1", "unitree_g1", "slider"])
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
    np.testing.assert_array_equal(prismatic_joints(q, q, robot)[0], with_upper_feet(q))


def least_speed(solver: GaitSolver, solve: Solve) -> float:
    """Forward velocity of the hip [m/s]."""
    return float(knee_trajectory(solver.problem, solve.variables).base_velocity[:, 0].min())


def test_a_bound_of_the_hip_is_kept_and_so_are_the_others():
    vx, share = 0.6, 0.97
    hip, free = solve_with(formulated(vx, phase="hip", hip_share=share)), solved(vx, 0.0)
    solve = hip.solve(vx, 0.0)
    assert solve.success, solve.status
    assert set(solve.residuals) == set(free.residuals) | {"hip_rate"}
    assert solve.max_violation <= config().library.max_violation
    assert knee_trajectory(problem(), free.variables).base_velocity[:, 0].min() < 0.95 * vx
    assert least_speed(hip, solve) == pytest.approx(share * vx, abs=1e-6)
    assert solve.cost > free.cost
    assert dense_violations(hip.problem, solve.variables)["hip_rate"] < 5e-3


def test_slow_gaits_have_no_bound_of_the_hip():
    hip = solve_with(formulated(0.2, phase="hip", hip_share=1.0))
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
