"""From a solved problem to a gait: its motion, polynomials, and violations between the nodes."""

from dataclasses import dataclass

import numpy as np

from slider.gait import bezier
from slider.gait.constraints import scaled_bounds
from slider.gait.problem import GaitProblem, blocks_of, excess
from slider.gait.transcription import NODE, ORDERS, ROLL_STATES
from slider.gait.tree import NUM_JOINTS
from slider.robot import knee_map
from slider.robot.kinematics import about_z

_AXIAL = np.array([-1.0, 1.0, -1.0])  # reflection of angular quantities
_POLAR = np.array([1.0, -1.0, 1.0])
DENSE = 10  # phases per node interval at which a solution is checked


@dataclass(frozen=True)
class KneeTrajectory:
    """A walk of S samples in virtual-knee coordinates, world axes, not reflected.

    In each step the origin is the middle of the stance foot's line, and x points along it. Joints:
    left leg, right leg.

    Attributes:
        q, v, torques: (S, 10) [rad], [rad/s], [N m].
        efforts: (S, 10) of the prismatic legs' joints [N m, N].
        base_rotation: (S, 3, 3); base_position, base_velocity: (S, 3) [m], [m/s], world.
        base_angular: (S, 3) [rad/s], base frame.
        wrench: (S, 6) ground force [N] and moment [N m] at the foot line.
        swing_foot: (S, 3) middle of the swing foot's line [m].
        ankle_rolls: (S, 3, 2) positions, velocities, efforts of ankle rolls; zero for line feet.
    """

    q: np.ndarray
    v: np.ndarray
    torques: np.ndarray
    efforts: np.ndarray
    base_rotation: np.ndarray
    base_position: np.ndarray
    base_velocity: np.ndarray
    base_angular: np.ndarray
    wrench: np.ndarray
    swing_foot: np.ndarray
    ankle_rolls: np.ndarray


def knee_trajectory(problem: GaitProblem, variables: np.ndarray) -> KneeTrajectory:
    """Evaluate all nodes of both steps and undo the second step's reflection."""
    nodes = problem.layout.node_vectors(variables).reshape(-1, NODE)
    values = [np.array(v).T for v in problem.functions["quantities"].map(len(nodes))(nodes.T)]
    q, v, torques, efforts, *values = values
    rotation, position, velocity, angular, force, moment, swing, rolls = values
    rolls = rolls.reshape(-1, 3, 2)
    rotation = rotation.reshape(-1, 3, 3).transpose(0, 2, 1)  # CasADi stacks columns
    second = slice(problem.layout.nodes, None)
    for joints in (q, v, torques, efforts):
        joints[second] = knee_map.reflected(joints[second], problem.form.robot.geometry)
    rotation[second] = _POLAR[:, None] * rotation[second] * _POLAR
    for polar in (position, velocity, force, swing):
        polar[second] *= _POLAR
    for axial in (angular, moment):
        axial[second] *= _AXIAL
    rolls[second] = -rolls[second, :, ::-1]
    wrench = np.concatenate([force, moment], axis=1)
    return KneeTrajectory(
        q, v, torques, efforts, rotation, position, velocity, angular, wrench, swing, rolls
    )


def base_motion(trajectory: KneeTrajectory, step_lengths: np.ndarray, turn: float) -> np.ndarray:
    """Base pose and velocity (S, 13) relative to the first stance foot.

    Position [m], quaternion w, x, y, z, linear velocity [m/s] (world), angular velocity [rad/s]
    (base frame), as a MuJoCo free joint has them. The second stance foot is at ``step_lengths``
    (2,) [m], yawed by ``turn`` [rad].
    """
    position, rotation = trajectory.base_position.copy(), trajectory.base_rotation.copy()
    velocity, second = trajectory.base_velocity.copy(), slice(len(position) // 2, None)
    if turn:
        axes = about_z(np.array([turn]))[0]
        position[second], velocity[second] = position[second] @ axes.T, velocity[second] @ axes.T
        rotation[second] = axes @ rotation[second]
    position[second, :2] += step_lengths
    quaternion = np.array([_quaternion(r) for r in rotation])
    return np.concatenate([position, quaternion, velocity, trajectory.base_angular], axis=1)


def _quaternion(r: np.ndarray) -> np.ndarray:
    """Unit quaternion w, x, y, z of a rotation by less than 180°."""
    w = np.sqrt(max(1.0 + np.trace(r), 1e-12)) / 2
    vector = np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]])
    return np.array([w, *(vector / (4 * w))])


def coefficients(problem: GaitProblem, variables: np.ndarray) -> np.ndarray:
    """Bézier coefficients (2, 10, degree + 1); the second step is reflected."""
    steps = [variables[problem.layout.joint_slice(step)] for step in range(2)]
    return np.stack(steps).reshape(2, NUM_JOINTS, -1)


def dense_violations(
    problem: GaitProblem, variables: np.ndarray, yaw_rate: float = 0.0
) -> dict[str, float]:
    """Worst violation by constraint at ``DENSE`` phases per node interval, SI units.

    ``yaw_rate`` [rad/s] is the commanded one. The roll equation holds at nodes only; between them
    its residual measures the collocation.
    """
    phase = np.linspace(0.0, 1.0, DENSE * (problem.layout.nodes - 1) + 1)
    lower, upper = scaled_bounds(problem.node_constraints, phase, at_nodes=False)
    x = dense_nodes(problem, variables, phase)
    turns = np.stack([yaw_rate * np.repeat([1.0, -1.0], len(phase)), np.tile(phase - 0.5, 2)])
    evaluate = problem.functions["node"].map(len(x))
    rows = np.array(evaluate(x.T, np.ones((1, len(x))), turns)[1]).T
    beyond = excess(rows, np.tile(lower, (2, 1)), np.tile(upper, (2, 1))).ravel()
    blocks = blocks_of(problem.node_constraints, len(x))
    return {block.name: float(beyond[block.rows].max() * block.scale) for block in blocks}


def dense_nodes(problem: GaitProblem, variables: np.ndarray, phase: np.ndarray) -> np.ndarray:
    """Node vectors (2 · phases, 34) at phases of both steps.

    Bézier joints are evaluated; the collocated roll is the integral of its quadratically
    interpolated derivative.
    """
    nodes, joints = problem.layout.node_vectors(variables), coefficients(problem, variables)
    dense = np.zeros((2, len(phase), NODE))
    dense[..., -1] = nodes[:, :1, -1]
    for step in range(2):
        time = nodes[step, 0, -1]
        rolls = nodes[step, :, :ROLL_STATES] * [1.0, time, time**2]
        rolls = between_nodes(rolls, phase)
        dense[step, :, :ROLL_STATES] = rolls / [1, time, time**2]
        orders = [bezier.evaluate(joints[step], phase, order) for order in range(ORDERS)]
        dense[step, :, ROLL_STATES:-1] = np.concatenate(orders, axis=1)
    return dense.reshape(-1, NODE)


def between_nodes(states: np.ndarray, phase: np.ndarray) -> np.ndarray:
    """Value, slope and curvature (phases, 3) of the collocation polynomials through (nodes, 3)."""
    pieces = (len(states) - 1) // 2
    piece = np.minimum((phase * pieces).astype(int), pieces - 1)
    width = 1.0 / pieces
    s = (phase - piece * width)[:, None]
    first, middle, last = (states[2 * piece + k] for k in range(3))
    # Parabolas through the three nodes of an interval, and their integrals.
    linear = (-3 * first + 4 * middle - last) / width
    square = 2 * (first - 2 * middle + last) / width**2
    integral = first * s + linear * s**2 / 2 + square * s**3 / 3
    result = first + linear * s + square * s**2
    result[:, :2] = first[:, :2] + integral[:, 1:]
    return result
