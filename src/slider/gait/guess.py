"""Initial guesses: a crouched walk, in place or forward, or a random perturbation of it."""

from typing import NamedTuple

import numpy as np

from slider.config.gait import StartSpread
from slider.config.robot import Mechanism, leg_scale
from slider.gait.problem import GaitProblem
from slider.gait.transcription import ROLL_STATES, Layout
from slider.gait.tree import LEG_JOINTS, NUM_JOINTS
from slider.robot.names import ANKLE, EXTENSION

LEG = 0.65  # hip-ankle distance that converts SLIDER's speed to a leg angle [m]
_PER_RADIAN = 0.2  # slide per radian of knee flexion, as a share of the leg's length
BUMP = 0.6  # extra flexion of the swing knee [rad]


class Start(NamedTuple):
    """Knee flexion [rad], and the longest step [m]; at higher speeds the steps are quicker."""

    crouch: float
    stride: float


STARTS = {
    "cold": Start(crouch=0.6, stride=0.6),
    "fast": Start(crouch=0.6, stride=0.45),
    "crouched": Start(crouch=1.1, stride=0.75),
}


def cold_start(
    layout: Layout,
    robot: Mechanism,
    vx: float,
    duration: tuple[float, float],
    start: Start,
) -> np.ndarray:
    """Variables (size,) of a gait at forward speed vx [m/s], scaled to SLIDER's leg length.

    ``duration``: bounds of the step time [s].
    """
    step_time = float(np.clip(start.stride / max(abs(vx), 1e-9), *duration))
    angles = crouched_walk(robot, vx * step_time / 2 / LEG, layout.degree + 1, start.crouch)
    return variables_of(layout, np.stack([angles, angles]), step_time)


def variables_of(layout: Layout, coefficients: np.ndarray, step_time: float) -> np.ndarray:
    """Variables (size,) from Bézier coefficients (2, 10, degree + 1) and step time [s]; no roll."""
    rolls = np.zeros(ROLL_STATES * layout.nodes)
    steps = [np.concatenate([step.ravel(), [step_time], rolls]) for step in coefficients]
    return np.concatenate(steps)


def crouched_walk(robot: Mechanism, swing: float, count: int, crouch: float) -> np.ndarray:
    """Bézier coefficients (10, count): the stance leg turns from +swing to −swing about vertical.

    A robot's own knees bend in their own direction, from their nominal flexion; a slide without a
    virtual knee shortens the leg as a knee halfway would.
    """
    s, bend = np.linspace(0.0, 1.0, count), robot.geometry.bend
    sense = np.sign(bend) or -1.0  # about y; the virtual knee's axis is −y, and it is straight at 0
    joints, pitch = np.zeros((NUM_JOINTS, count)), robot.geometry.sagittal[0]
    stance = swing * (1 - 2 * s)
    bent = crouch + BUMP * np.sin(np.pi * s)
    for leg, forward, flexion in ((0, stance, crouch + 0 * s), (LEG_JOINTS, -stance, bent)):
        if robot.virtual_knee is None and not bend:
            length = robot.geometry.leg_length
            joints[leg + pitch], joints[leg + ANKLE] = -forward, forward
            joints[leg + EXTENSION] = LEG * leg_scale(length) * np.cos(flexion / 2) - length
            continue
        turn = sense * flexion - bend
        joints[leg + pitch] = -turn / 2 - forward
        joints[leg + EXTENSION] = turn if bend else -turn
        joints[leg + ANKLE] = -turn / 2 + forward
    return joints


def random_start(
    problem: GaitProblem,
    vx: float,
    duration: tuple[float, float],
    spread: StartSpread,
    generator: np.random.Generator,
) -> np.ndarray:
    """Random variables (size,) around a crouched walk at forward speed vx [m/s], within bounds.

    ``duration``: bounds of the step time [s]. The two steps differ.
    """
    step_time = generator.uniform(*duration)
    crouch = generator.uniform(spread.crouch.lower, spread.crouch.upper)
    stride = vx * step_time * generator.uniform(spread.stride.lower, spread.stride.upper)
    leg = LEG * problem.form.leg_scale
    robot = problem.form.robot
    walk = crouched_walk(robot, stride / 2 / leg, problem.layout.degree + 1, crouch)
    noise = generator.uniform(-spread.joints, spread.joints, (2, *walk.shape))
    if robot.virtual_knee is None and robot.geometry.knee is None:
        noise[:, [EXTENSION, LEG_JOINTS + EXTENSION]] *= _PER_RADIAN * robot.geometry.leg_length
    start = variables_of(problem.layout, walk + noise, step_time)
    return np.clip(start, *problem.variable_bounds(duration))
