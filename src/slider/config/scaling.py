"""Defaults that follow the robot: ``${by_leg:0.4}`` is 0.4 for SLIDER and in proportion for others.

Times and speeds grow with the root of the leg's length: walks of the same Froude number v²/(g l)
are alike. A number in the place of the expression stays as it is typed.
"""

from collections.abc import Callable
from typing import Any

from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from slider.config.robot import leg_scale

_HALF_WIDTH = 0.1  # between the pitch axes of SLIDER [m]
_MASS = 12.5248  # [kg]


def _mass(robot: Any) -> float:
    """Mass of the base and of two legs [kg]."""
    return sum(link.mass * (1 if name == "base" else 2) for name, link in robot.links.items())


def _register(name: str, scale: Callable[[Any], float]) -> None:
    def resolve(value: float, *, _root_: DictConfig) -> float:
        try:
            factor = round(scale(_root_.robot), 12)  # a sum of masses has wrong last digits
            return value * factor if factor > 0.0 else value
        except (OmegaConfBaseException, TypeError, AttributeError):
            return value  # the schema has a line about the robot's value, which comes first

    OmegaConf.register_new_resolver(name, resolve, replace=True)


_register("by_leg", lambda robot: leg_scale(robot.geometry.leg_length))
_register("by_time", lambda robot: leg_scale(robot.geometry.leg_length) ** 0.5)
_register("by_speed", lambda robot: leg_scale(robot.geometry.leg_length) ** 0.5)
_register("by_rate", lambda robot: leg_scale(robot.geometry.leg_length) ** -0.5)
_register("by_hip", lambda robot: sum(p[1] for p in robot.geometry.axes.values()) / _HALF_WIDTH)
_register("by_weight", lambda robot: _mass(robot) / _MASS)
