"""Checks of disturbances: sensing, drives, body, pushes and ground."""

from dataclasses import fields

from slider.config.disturbance import DisturbanceConfig, GroundConfig
from slider.config.env import EnvConfig
from slider.config.interval import Interval
from slider.config.validation.checks import (
    all_at_least,
    at_least,
    interval,
    multiple,
    positive,
    require,
)

MAX_CELLS = 400


def check_disturbance(disturbance: DisturbanceConfig, env: EnvConfig, key: str) -> None:
    """Ranges, and times that the simulation can hit."""
    names = [item.name for item in fields(disturbance.sensing)]
    all_at_least(f"{key}.sensing", disturbance.sensing, names, 0)
    _ranges(disturbance, key)
    for name in ("lower", "upper"):
        delay = getattr(disturbance.delay, name)
        multiple(f"{key}.delay.{name}", delay, env.physics.timestep)
    push = disturbance.push
    all_at_least(key, disturbance, ("centre_of_mass", "push.speed"), 0)
    positive(f"{key}.push.interval", push.interval)
    multiple(f"{key}.push.interval", push.interval, env.control_period)
    _ground(disturbance.ground, f"{key}.ground")


def _ranges(disturbance: DisturbanceConfig, key: str) -> None:
    """A delay may be zero; a factor may not."""
    for name in ("delay", "motor_gain", "mass", "friction"):
        value: Interval | None = getattr(disturbance, name)
        if value is None:
            continue
        interval(f"{key}.{name}", value)
        if name == "delay":
            at_least(f"{key}.{name}.lower", value.lower, 0)
        else:
            positive(f"{key}.{name}.lower", value.lower)


def _ground(ground: GroundConfig, key: str) -> None:
    at_least(f"{key}.amplitude", ground.amplitude, 0)
    positive(f"{key}.cell", ground.cell)
    positive(f"{key}.period", ground.period)
    multiple(f"{key}.period", ground.period, ground.cell)
    cells = round(ground.period / ground.cell)
    require(cells <= MAX_CELLS, f"{key}.period", f"at most {MAX_CELLS} cells", cells)
