"""Steps of a stored gait, as the closed loop follows them."""

from dataclasses import replace

import numpy as np

from slider.config.hzd import VirtualConstraintsConfig
from slider.gait.rooted import NUM
from slider.hzd.model import RootedModel
from slider.hzd.outputs import JOINTS, ROLL
from slider.hzd.polynomials import NodeTable
from slider.hzd.step import StepPlan
from slider.library.reader import GaitLibrary
from slider.robot.knee_map import KneeLengths

_HIP_NODES = 41


def plans(
    library: GaitLibrary, gait: int, model: RootedModel, config: VirtualConstraintsConfig
) -> list[StepPlan]:
    """Both steps of a gait, the second reflected."""
    return [_plan(library, gait, step, model, config) for step in range(2)]


def _plan(
    library: GaitLibrary,
    gait: int,
    step: int,
    model: RootedModel,
    config: VirtualConstraintsConfig,
) -> StepPlan:
    duration = float(library.step_time[gait, step])
    rolls = library.arrays["roll"][gait, step][None] * duration ** np.arange(3)
    plan = StepPlan(
        library.arrays["coefficients"][gait, step],
        NodeTable(rolls[..., :1], rolls[..., 1:2], rolls[..., 2:]),
        NodeTable(*np.zeros((2, 1, 2, 1))),
        np.zeros((NUM - 1, 2)),
        duration,
        config.phase == "time" or library.velocities[gait, 0] < config.slowest_hip,
        KneeLengths.of(library.robot),
    )
    return _complete(plan, model, config)


def _complete(plan: StepPlan, model: RootedModel, config: VirtualConstraintsConfig) -> StepPlan:
    """With its hip and its placement matrix."""
    orders = motion(plan, np.linspace(0.0, 1.0, _HIP_NODES), config)
    hip = model.measure(orders[0], orders[1]).hip
    _, _, slope, bend = model.constrained(orders[0], orders[1])
    rate = (slope * orders[1]).sum(axis=1)
    curve = bend + (slope * orders[2]).sum(axis=1)
    table = NodeTable(*(values[None, :, None] for values in (hip, rate, curve)))
    return replace(plan, hip=table, placement=model.placement(orders[0][-1:])[0])


def motion(plan: StepPlan, phase: np.ndarray, config: VirtualConstraintsConfig) -> np.ndarray:
    """q of the gait (3, n, 11) and its derivatives over the phase at phases (n,)."""
    orders = np.stack(plan.constraints(len(phase), config).desired(phase))
    return orders[..., [ROLL, *range(JOINTS, orders.shape[-1])]]


def start(plan: StepPlan, config: VirtualConstraintsConfig) -> np.ndarray:
    """State (22,) of the collocated gait just after its impact."""
    q, rate, _ = motion(plan, np.zeros(1), config)
    return np.concatenate([q[0], rate[0] / plan.duration])
