"""Variables to nodes, and the roll between them."""

import numpy as np

from slider.gait import bezier
from slider.gait.solution import between_nodes
from slider.gait.transcription import Layout

NODES = 9


def test_nodes_have_the_polynomials_of_both_steps_and_their_derivatives():
    layout = Layout(NODES, 3)
    variables = np.random.default_rng(0).normal(size=layout.size)
    nodes = layout.node_vectors(variables)
    for step in range(2):
        coefficients = variables[layout.joint_slice(step)].reshape(10, 4)
        for order in range(3):
            expected = bezier.evaluate(coefficients, layout.phase, order)
            found = nodes[step, :, 3 + 10 * order : 13 + 10 * order]
            np.testing.assert_allclose(found, expected, atol=1e-12)
        time = layout.time_index(step)
        rolls = variables[time + 1 : time + 1 + 3 * NODES].reshape(NODES, 3)
        np.testing.assert_array_equal(nodes[step, :, :3], rolls)
        assert (nodes[step, :, -1] == variables[time]).all()


def test_between_nodes_collocated_motion_is_a_cubic():
    coefficients = np.random.default_rng(2).normal(size=(1, 4))
    phases = np.linspace(0.0, 1.0, NODES), np.linspace(0.0, 1.0, 57)
    states, expected = (
        np.concatenate([bezier.evaluate(coefficients, phase, order) for order in range(3)], axis=1)
        for phase in phases
    )
    np.testing.assert_allclose(between_nodes(states, phases[1]), expected, atol=1e-10)
