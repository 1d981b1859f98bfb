"""Rollouts of the model-based controllers in the simulator."""

from functools import cache

import numpy as np

from slider.config.control import AnyControl
from slider.config.env import StartNoise
from slider.control.hzd.gaits import EnforcedGaits
from slider.control.model_based import build_controller, build_plant
from slider.control.whole_body.controller import WalkingController
from slider.control.whole_body.model import NominalModel
from slider.env.disturbance import Disturbance
from slider.env.rollout import Recording, roll_out
from slider.env.starts import at_rest
from tests.env.synthetic import config, robot_config

COUNT = 2
STILL = StartNoise(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
Segment = tuple[float, tuple[float, float, float]]
"""How long [s], and the velocity."""


@cache
def nominal() -> NominalModel:
    return NominalModel(robot_config())


def walk(
    control: str | AnyControl,
    *segments: Segment,
    noise: bool = False,
    count: int = COUNT,
    drawn: Disturbance | None = None,
    gaits: EnforcedGaits | None = None,
) -> tuple[Recording, WalkingController]:
    """Robots that are told velocities."""
    whole, robot = config(), robot_config()
    control = whole.control[control] if isinstance(control, str) else control
    physics = build_plant(robot, whole.env.plant, control, count, drawn)
    controller = build_controller(robot, control, whole.env.physics, count, gaits)
    spread = whole.evaluation.start if noise else STILL
    start = at_rest(robot, spread, np.random.default_rng(7), count)
    velocities = np.concatenate([np.tile(v, (round(t / 0.02), count, 1)) for t, v in segments])
    seconds = sum(t for t, _ in segments)
    return roll_out(controller, physics, whole.env, start, velocities, seconds), controller
