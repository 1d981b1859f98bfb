"""The lists of constraints: where their bounds come from, and what a change of one does."""

from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from slider.config.types import Interval
from slider.gait.constraints import Constraint, equality, of_node, scaled_bounds
from slider.gait.formulation import Formulation, Node
from slider.gait.problem import build
from slider.gait.solution import knee_trajectory
from slider.gait.solve import GaitSolver
from slider.gait.transcription import NODE
from tests.gait.gaits import config, form, nodes, problem, solved

METHOD = Path(__file__).parents[2] / "docs" / "explanation" / "method.md"


def test_the_documentation_names_every_constraint():
    text = METHOD.read_text()
    names = {c.name for c in [*problem().node_constraints, *problem().end_constraints]}
    for name in names - {*config().gait.bounds}:
        assert f"`{name}`" in text, name


def test_a_bound_of_the_configuration_bounds_the_rows_of_that_name():
    """A solved gait violates a bound that it was not solved for, and that one alone."""
    gait = config().gait
    assert violated(form()) == set()
    for key, value, name in (
        ("legs_apart", 1.0, "legs_apart"),
        ("torso_rate", 1e-3, "torso_rate"),
        ("torso_pitch", 1e-4, "torso"),
        ("swing_height", 0.053, "clearance"),
        ("foot_separation_max", 0.13, "foot_separation"),
    ):
        changed = replace(gait, posture=replace(gait.posture, **{key: value}))
        assert violated(Formulation(config().robot, changed)) == {name}


def violated(formulation) -> set[str]:
    x = ca.SX.sym("x", NODE)
    names, phase = set(), problem().layout.phase
    for constraint in of_node(Node(formulation, x, ca.SX(2, 1))):
        rows = ca.Function("rows", [x], [constraint.expression / constraint.scale])
        lower, upper = (np.tile(bound, (2, 1)) for bound in constraint.bounds(phase))
        values = np.array(rows.map(2 * len(phase))(nodes(0.4, 0.0).T)).T
        if (values < lower - 1e-6).any() or (values > upper + 1e-6).any():
            names.add(constraint.name)
    assert solved(0.4, 0.0).success
    return names


def test_the_clearance_begins_at_its_phase():
    clearance = next(c for c in problem().node_constraints if c.name == "clearance")
    lower, _ = clearance.bounds(np.array([0.0, 0.04, 0.05, 0.5, 0.96, 1.0]), at_nodes=False)
    expected = [-np.inf, 0.0, 0.05 * 4 * 0.05 * 0.95, 0.05, 0.0, -np.inf]
    np.testing.assert_allclose(lower[:, 0] * clearance.scale, expected)


def test_bounds_are_scaled_and_keep_a_margin_at_the_nodes():
    rows, phase = ca.SX.sym("r", 2), np.array([0.0, 0.5, 1.0])

    def arc(phase: np.ndarray) -> np.ndarray:
        return np.stack([phase, 2 * phase], axis=1)

    with_margin = Constraint("a", rows, arc, 3.0, 0.5, lambda phase: arc(phase) + 0.25)
    lower, upper = scaled_bounds([with_margin, equality("b", rows[0], 10.0)], phase)
    np.testing.assert_allclose(lower, [[0.5, 0.5, 0], [1.5, 2.5, 0], [2.5, 4.5, 0]])
    np.testing.assert_allclose(upper, [[6, 6, 0]] * 3)
    between_nodes = scaled_bounds([with_margin], phase, at_nodes=False)[0]
    np.testing.assert_allclose(between_nodes, [[0, 0], [1, 2], [2, 4]])


def test_a_registered_row_is_bounded_by_its_line_in_the_configuration():
    """The base is lower than without the bound, and the worst residual has the row's name."""
    height, free = 0.66, knee_trajectory(problem(), solved(0.4, 0.0).variables).base_position
    assert free[:, 2].max() > height + 0.005
    gait = replace(config().gait, bounds={"base_height": Interval(0.0, height)})
    low = build(Formulation(config().robot, gait))
    solve = GaitSolver(low, gait.solver, gait.step_time).solve(0.4, 0.0)
    assert solve.success, solve.status
    assert solve.residuals["base_height"] <= 1e-6
    base = knee_trajectory(low, solve.variables).base_position[:, 2]
    assert base.max() == pytest.approx(height, abs=1e-5)
