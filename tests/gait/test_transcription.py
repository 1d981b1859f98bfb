"""Joint variables to nodes: polynomials, and Hermite-Simpson collocation."""

import numpy as np
import pytest

from slider.gait import bezier
from slider.gait.solution import between_nodes
from slider.gait.transcription import bezier_joints, collocated_joints, from_polynomials

NODES = 9


def orders(transcription, variables) -> np.ndarray:
    return (transcription.nodes @ variables).reshape(3, NODES, 10)


@pytest.mark.parametrize("name", ["bezier", "collocation"])
def test_both_represent_a_cubic_exactly(name):
    """Hermite-Simpson, separated, integrates a quadratic slope without error."""
    coefficients = np.random.default_rng(0).normal(size=(10, 4))
    transcription = bezier_joints(NODES, 3) if name == "bezier" else collocated_joints(NODES)
    variables = from_polynomials(transcription, coefficients)
    assert variables.shape == (transcription.size,)
    found = orders(transcription, variables)
    phase = np.linspace(0.0, 1.0, NODES)
    for order in range(3):
        expected = bezier.evaluate(coefficients, phase, order)
        np.testing.assert_allclose(found[order], expected, atol=1e-12)
    np.testing.assert_allclose(transcription.defects @ variables, 0.0, atol=1e-12)


def test_defects_see_a_wrong_derivative():
    transcription = collocated_joints(NODES)
    variables = from_polynomials(transcription, np.random.default_rng(1).normal(size=(10, 4)))
    for place in range(transcription.size):
        wrong = variables.copy()
        wrong[place] += 1.0
        assert np.abs(transcription.defects @ wrong).max() > 1e-3


def test_between_nodes_collocated_motion_is_a_cubic():
    coefficients = np.random.default_rng(2).normal(size=(10, 4))
    phase, dense = np.linspace(0.0, 1.0, NODES), np.linspace(0.0, 1.0, 57)
    states = np.stack([bezier.evaluate(coefficients, phase, order) for order in range(3)], axis=1)
    expected = np.stack([bezier.evaluate(coefficients, dense, order) for order in range(3)], axis=1)
    np.testing.assert_allclose(between_nodes(states, dense), expected, atol=1e-10)
