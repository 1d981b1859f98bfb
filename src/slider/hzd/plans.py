"""Steps of stored gaits, as the closed loop follows them."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from slider.config.hzd import VirtualConstraintsConfig
from slider.core.arrays import take
from slider.core.errors import UserError
from slider.gait.outputs import JOINTS, ROLL
from slider.gait.rooted import NUM
from slider.hzd.constraints import NodeTable, Steps
from slider.hzd.model import RootedModel
from slider.library.reader import GaitLibrary
from slider.robot.knee_map import KneeLengths
from slider.robot.names import velocity_text

_NODES = 41


@dataclass(frozen=True)
class StepPlan(Steps):
    """References of the steps.

    Attributes:
        hip: forward position of the base's origin from the stance sole (n, K, 1) [m].
        ankle: effort of the stance ankle (n, K, 1) [N m].
        duration: T (n,) [s].
        clock: whether the phase is time (n,).
    """

    hip: NodeTable
    ankle: NodeTable
    duration: np.ndarray
    clock: np.ndarray


def plans(
    library: GaitLibrary, gaits: np.ndarray, model: RootedModel, config: VirtualConstraintsConfig
) -> tuple[StepPlan, StepPlan]:
    """Both steps of some gaits by index (n,), the second reflected.

    Raises:
        UserError: the phase is the hip, and the hip of a gait moves backward.
    """
    first, second = (_plan(library, gaits, step, model, config) for step in range(2))
    for plan in (first, second):
        for gait in gaits[~plan.clock & (plan.hip.slopes[..., 0].min(axis=1) <= 0.0)]:
            expected = "expected a hip that moves forward at every phase"
            velocity = velocity_text(library.velocities[gait])
            raise UserError(f"{expected}, found one that turns back in the gait {velocity}")
    return first, second


def _plan(
    library: GaitLibrary,
    gaits: np.ndarray,
    step: int,
    model: RootedModel,
    config: VirtualConstraintsConfig,
) -> StepPlan:
    n, duration = len(gaits), library.arrays["step_time"][gaits, step]
    per_phase = duration[:, None] ** np.arange(3)
    rolls = library.arrays["roll"][gaits, step] * per_phase[:, None]
    steps = Steps(
        library.arrays["coefficients"][gaits, step],
        NodeTable(rolls[..., :1], rolls[..., 1:2], rolls[..., 2:]),
        np.zeros((n, NUM - 1, 2)),
        KneeLengths.of(library.robot),
        library.robot.geometry.slide_length,
    )
    placement = model.placement(motion(steps, np.ones(n), config)[0])
    phase, rows = np.linspace(0.0, 1.0, _NODES), np.repeat(np.arange(n), _NODES)
    q, rate, turn = motion(take(steps, rows), np.tile(phase, n), config)
    _, _, slope, bend = model.constrained(q, rate)
    orders = (
        model.measure(q, rate).hip,
        (slope * rate).sum(axis=1),
        bend + (slope * turn).sum(axis=1),
    )
    hip = NodeTable(*(order.reshape(n, _NODES, 1) for order in orders))
    durations = duration[rows, None]
    mass, bias, _, _ = model.constrained(q, rate / durations)
    effort = (mass[:, 1] * turn / durations**2).sum(axis=1) + bias[:, 1]
    effort = effort.reshape(n, _NODES, 1)
    ankle = NodeTable(effort, CubicSpline(phase, effort, axis=1)(phase, 1))
    clock = library.velocities[gaits, 0] < config.slowest_hip
    legs = steps.coefficients, steps.roll, placement, steps.lengths, steps.slide_length
    return StepPlan(*legs, hip, ankle, duration, clock)


def motion(steps: Steps, phase: np.ndarray, config: VirtualConstraintsConfig) -> np.ndarray:
    """q of n gaits at phases (n,), and its derivatives over the phase (3, n, 11)."""
    orders = np.stack(steps.constraints(config).desired(phase))
    return orders[..., [ROLL, *range(JOINTS, orders.shape[-1])]]


def start(plan: StepPlan, config: VirtualConstraintsConfig) -> np.ndarray:
    """States (n, 22) of the collocated gaits at the start of the step."""
    q, rate, _ = motion(plan, np.zeros(len(plan.duration)), config)
    return np.concatenate([q, rate / plan.duration[:, None]], axis=1)
