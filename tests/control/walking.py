"""Rollouts of the model-based controllers in the simulator."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from slider.config.control import AnyControl
from slider.config.env import StartNoise
from slider.config.robot import RobotConfig
from slider.control.hzd.gaits import EnforcedGaits
from slider.control.model_based import build_controller
from slider.control.whole_body.controller import WalkingController
from slider.env.disturbance import Disturbance
from slider.env.physics import BatchedPhysics
from slider.env.rollout import Recording, roll_out
from slider.env.starts import at_rest
from tests.env.synthetic import config, robot_config

COUNT = 2
STILL = StartNoise(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
Segment = tuple[float, tuple[float, float, float]]
"""How long [s], and the velocity."""


def walk(
    control: str | AnyControl,
    *segments: Segment,
    noise: bool = False,
    count: int = COUNT,
    plant: RobotConfig | None = None,
    drawn: Disturbance | None = None,
    gaits: EnforcedGaits | None = None,
    watch: Callable[[BatchedPhysics], None] = lambda _: None,
) -> tuple[Recording, WalkingController]:
    """Robots that are told velocities; ``watch`` gets their physics."""
    whole = config()
    control = whole.control[control] if isinstance(control, str) else control
    settings = replace(whole.env.physics, substeps=control.substeps)
    physics = BatchedPhysics(plant or robot_config(), settings, count, 1, "torque", drawn)
    watch(physics)
    controller = build_controller(robot_config(), control, whole.env.physics, count, gaits)
    spread = whole.evaluation.start if noise else STILL
    start = at_rest(robot_config(), spread, np.random.default_rng(7), count)
    velocities = np.concatenate([np.tile(v, (round(t / 0.02), count, 1)) for t, v in segments])
    seconds = sum(t for t, _ in segments)
    return roll_out(controller, physics, whole.env, start, velocities, seconds), controller
