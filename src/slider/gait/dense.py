"""A solution between its nodes: the constraints of a node at many phases."""

import numpy as np

from slider.gait import bezier
from slider.gait.constraint import scaled_bounds
from slider.gait.layout import NODE, ROLL_STATES
from slider.gait.problem import GaitProblem, node_blocks
from slider.gait.tree import NUM_JOINTS

DENSE = 10  # phases per node interval at which a solution is checked


def dense_violations(
    problem: GaitProblem, variables: np.ndarray, yaw_rate: float = 0.0
) -> dict[str, float]:
    """Worst violation by name at ``DENSE`` phases per node interval, SI units.

    ``yaw_rate`` [rad/s] is the commanded one.

    The roll equation holds at nodes only; between them its residual measures the collocation.
    """
    phase = _phase(problem)
    lower, upper = scaled_bounds(problem.node_constraints, phase, at_nodes=False)
    x = dense_nodes(problem, variables)
    turns = np.stack([yaw_rate * np.repeat([1.0, -1.0], len(phase)), np.tile(phase - 0.5, 2)])
    evaluate = problem.node.value.map(len(x))
    rows = np.array(evaluate(x.T, np.ones((1, len(x))), turns)[1]).T
    lower, upper = np.tile(lower, (2, 1)), np.tile(upper, (2, 1))
    excess = np.maximum(np.maximum(lower - rows, rows - upper), 0.0).ravel()
    blocks = node_blocks(problem.node_constraints, len(x))
    return {block.name: float(excess[block.rows].max() * block.scale) for block in blocks}


def dense_nodes(problem: GaitProblem, variables: np.ndarray) -> np.ndarray:
    """Node vectors (2 · phases, 34) between the nodes.

    Bézier joints are evaluated; what is collocated is the integral of its quadratically
    interpolated derivative.
    """
    layout = problem.layout
    nodes = layout.node_vectors(variables)
    phase = _phase(problem)
    dense = np.zeros((2, len(phase), NODE))
    dense[..., -1] = nodes[:, :1, -1]
    for step in range(2):
        time = nodes[step, 0, -1]
        rolls = nodes[step, :, :ROLL_STATES] * [1.0, time, time**2]
        dense[step, :, :ROLL_STATES] = between_nodes(rolls[..., None], phase)[..., 0] / [
            1,
            time,
            time**2,
        ]
        dense[step, :, ROLL_STATES:-1] = _joints(problem, variables, nodes, step, phase)
    return dense.reshape(-1, NODE)


def _phase(problem: GaitProblem) -> np.ndarray:
    return np.linspace(0.0, 1.0, DENSE * (problem.nodes - 1) + 1)


def _joints(
    problem: GaitProblem, variables: np.ndarray, nodes: np.ndarray, step: int, phase: np.ndarray
) -> np.ndarray:
    """Joints and their derivatives over the phase (phases, 30)."""
    layout = problem.layout
    if problem.config.transcription == "bezier":
        coefficients = variables[layout.joint_slice(step)].reshape(NUM_JOINTS, -1)
        orders = [bezier.evaluate(coefficients, phase, order) for order in range(3)]
        return np.concatenate(orders, axis=1)
    states = nodes[step, :, ROLL_STATES:-1].reshape(layout.nodes, 3, NUM_JOINTS)
    return between_nodes(states, phase).reshape(len(phase), -1)


def between_nodes(states: np.ndarray, phase: np.ndarray) -> np.ndarray:
    """Value, slope and curvature (phases, 3, n) of the collocation polynomials of (nodes, 3, n)."""
    pieces = (len(states) - 1) // 2
    piece = np.minimum((phase * pieces).astype(int), pieces - 1)
    width = 1.0 / pieces
    s = (phase - piece * width)[:, None]
    nodes = [states[2 * piece + k] for k in range(3)]
    value = nodes[0][:, 0] + _integral([node[:, 1] for node in nodes], width, s)
    slope = nodes[0][:, 1] + _integral([node[:, 2] for node in nodes], width, s)
    linear, square = _quadratic([node[:, 2] for node in nodes], width)
    curvature = nodes[0][:, 2] + linear * s + square * s**2
    return np.stack([value, slope, curvature], axis=1)


def _quadratic(nodes: list[np.ndarray], width: float) -> tuple[np.ndarray, np.ndarray]:
    """Linear and quadratic coefficients through start, middle and end of an interval."""
    first, middle, last = nodes
    return (-3 * first + 4 * middle - last) / width, 2 * (first - 2 * middle + last) / width**2


def _integral(nodes: list[np.ndarray], width: float, s: np.ndarray) -> np.ndarray:
    linear, square = _quadratic(nodes, width)
    return nodes[0] * s + linear * s**2 / 2 + square * s**3 / 3
