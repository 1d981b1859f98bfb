"""The generic cold start: a crouched walk in place or forward, the same for every robot state."""

import numpy as np

from slider.gait.problem import ROLL_STATES, GaitProblem
from slider.gait.tree import LEG_JOINTS, NUM_JOINTS

CROUCH = 0.9  # knee flexion [rad]
LEG = 0.65  # hip-ankle distance that turns speed into leg angle [m]
BUMP = 0.6  # extra flexion of the swing knee [rad]
STRIDE = 0.6  # longest step that the start assumes [m]


def cold_start(problem: GaitProblem, vx: float) -> np.ndarray:
    """Variables (size,) of a crouched gait at forward speed vx [m/s]."""
    times = problem.formulation.config.step_time
    step_time = float(np.clip(STRIDE / max(abs(vx), 1e-9), times.lower, times.upper))
    angles = _joints(vx * step_time / 2 / LEG, problem.degree + 1)
    step = np.concatenate([angles.ravel(), [step_time], np.zeros(ROLL_STATES * problem.nodes)])
    return np.tile(step, 2)


def _joints(swing: float, count: int) -> np.ndarray:
    """Bézier coefficients (10, count): legs swing from +swing to −swing about vertical."""
    s = np.linspace(0.0, 1.0, count)
    joints = np.zeros((NUM_JOINTS, count))
    stance = swing * (1 - 2 * s)
    bump = BUMP * np.sin(np.pi * s)
    for leg, forward, flexion in (
        (0, stance, CROUCH + 0 * s),
        (LEG_JOINTS, -stance, CROUCH + bump),
    ):
        joints[leg + 2] = flexion / 2 - forward
        joints[leg + 3] = flexion
        joints[leg + 4] = flexion / 2 + forward
    return joints
