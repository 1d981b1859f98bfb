"""How the joints' motion over a step depends on variables: linearly, in two ways.

``bezier``: virtual constraints, polynomials of the phase. ``collocation``: positions,
velocities and accelerations of all joints at every node, tied by Hermite-Simpson defects.
"""

from dataclasses import dataclass

import numpy as np

from slider.gait import bezier
from slider.gait.tree import NUM_JOINTS

ORDERS = 3  # positions and their first and second derivatives with respect to the phase
# Of collocated variables: brings derivatives over the phase near one.
_SCALES = (1.0, 10.0, 100.0)


@dataclass(frozen=True)
class Transcription:
    """Joint variables of one step.

    Attributes:
        size: number of variables.
        nodes: (3 · nodes · 10, size) to the orders, nodes and joints, in this nesting.
        defects: (rows, size), zero for a valid motion.
        bounded: (size,) the joint whose position a variable is (or bounds), −1 for others.
    """

    size: int
    nodes: np.ndarray
    defects: np.ndarray
    bounded: np.ndarray


def bezier_joints(nodes: int, degree: int) -> Transcription:
    """Coefficients of the ten joints, joint by joint."""
    phase, width = np.linspace(0.0, 1.0, nodes), degree + 1
    size = NUM_JOINTS * width
    blocks = [_interleave(bezier.basis_derivative(degree, phase, order)) for order in range(ORDERS)]
    joints = np.repeat(np.arange(NUM_JOINTS), width)  # a polynomial stays in its coefficients' hull
    return Transcription(size, np.concatenate(blocks), np.zeros((0, size)), joints)


def _interleave(basis: np.ndarray) -> np.ndarray:
    """(nodes · 10, 10 · width) from a basis (nodes, width)."""
    return np.einsum("kw,ij->kijw", basis, np.eye(NUM_JOINTS)).reshape(
        len(basis) * NUM_JOINTS, NUM_JOINTS * basis.shape[1]
    )


def collocated_joints(nodes: int) -> Transcription:
    """Values of the three orders at every node, node by node."""
    width = ORDERS * NUM_JOINTS
    eye = np.eye(nodes * width)
    place = np.arange(nodes * width).reshape(nodes, ORDERS, NUM_JOINTS)
    orders = [eye[place[:, order].ravel()] * _SCALES[order] for order in range(ORDERS)]
    joints = np.full((nodes, ORDERS, NUM_JOINTS), -1)
    joints[:, 0] = np.arange(NUM_JOINTS)
    defects = [_defects(orders[order], orders[order + 1], nodes) for order in range(ORDERS - 1)]
    return Transcription(
        nodes * width, np.concatenate(orders), np.concatenate(defects), joints.ravel()
    )


def _defects(value: np.ndarray, slope: np.ndarray, nodes: int) -> np.ndarray:
    """Hermite-Simpson rows, separated form, of a quantity and its derivative."""
    interval = 2.0 / (nodes - 1)
    rows = np.arange(nodes * NUM_JOINTS).reshape(nodes, NUM_JOINTS)
    a, m, b = (rows[start : nodes - 2 + start : 2].ravel() for start in range(3))
    middle = value[m] - (value[a] + value[b]) / 2 - interval / 8 * (slope[a] - slope[b])
    end = value[b] - value[a] - interval / 6 * (slope[a] + 4 * slope[m] + slope[b])
    return np.concatenate([middle, end])


def from_polynomials(transcription: Transcription, coefficients: np.ndarray) -> np.ndarray:
    """Variables (size,) of Bézier polynomials (10, degree + 1); exact where they are the same."""
    if transcription.size == coefficients.size and transcription.defects.shape[0] == 0:
        return coefficients.ravel()
    per_order = transcription.nodes.shape[0] // ORDERS // NUM_JOINTS
    phase = np.linspace(0.0, 1.0, per_order)
    values = [bezier.evaluate(coefficients, phase, order) for order in range(ORDERS)]
    scaled = [value / scale for value, scale in zip(values, _SCALES, strict=True)]
    return np.stack(scaled, axis=1).ravel()
