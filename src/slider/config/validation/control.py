"""Checks of the model-predictive baseline's settings."""

from dataclasses import fields

from slider.config.control import ControlConfig, MpcConfig, ObserverConfig
from slider.config.env import EnvConfig, PhysicsConfig
from slider.config.validation.checks import (
    all_positive,
    at_least,
    multiple,
    ordered,
    positive,
    require,
    share,
)

LEAST_RATE = 200  # [Hz]

_POSITIVE = (
    "step.time_min",
    "step.width",
    "step.apex",
    "planner.period",
    "planner.lock",
    "planner.acceleration",
    "entry.duration",
    "whole_body.friction",
    "whole_body.force_max",
)


def check_controls(controls: ControlConfig, env: EnvConfig) -> None:
    """Every setting of the baseline."""
    for item in fields(controls):
        _control(getattr(controls, item.name), env, f"control.{item.name}")


def _control(control: MpcConfig, env: EnvConfig, key: str) -> None:
    step, planner = control.step, control.planner
    _substeps(control.substeps, env.physics, f"{key}.substeps")
    ordered(f"{key}.step", step.time_min, step.time)
    ordered(f"{key}.step", step.time, step.time_max)
    all_positive(key, control, _POSITIVE)
    for index in (0, 1):
        weight = control.whole_body.regularisation[index]
        positive(f"{key}.whole_body.regularisation[{index}]", weight)
    at_least(f"{key}.step.time_change", step.time_change, 0.0)
    at_least(f"{key}.planner.steps", planner.steps, 1)
    ordered(f"{key}.planner.width_min", planner.width_min, planner.width_max)
    if control.observer is not None:
        period = env.physics.timestep * control.substeps
        _observer(control.observer, period, f"{key}.observer")


def _observer(observer: ObserverConfig, period: float, key: str) -> None:
    at_least(f"{key}.delay", observer.delay, 0)
    multiple(f"{key}.delay", observer.delay, period)
    share(f"{key}.position", observer.position)
    share(f"{key}.velocity", observer.velocity)


def _substeps(substeps: int, physics: PhysicsConfig, key: str) -> None:
    """Ticks of the controller end with steps of the physics, and are short."""
    at_least(key, substeps, 1)
    divides = physics.substeps % substeps == 0
    require(divides, key, f"a divisor of env.physics.substeps ({physics.substeps})", substeps)
    rate = 1 / (physics.timestep * substeps)
    expected = f"a control rate of at least {LEAST_RATE} Hz"
    require(rate > LEAST_RATE - 0.1, key, expected, f"{rate:.0f} Hz")
