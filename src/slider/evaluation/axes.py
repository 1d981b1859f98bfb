"""Axes of the gauge: how a level disturbs a robot, and what it is in words."""

from dataclasses import replace

from slider.config.env import DisturbanceConfig, SensingConfig, TerrainConfig
from slider.config.evaluation import TERRAINS
from slider.config.types import Interval
from slider.env.terrain import magnitude

_WORDS = {  # of a value: text, and shown number per stored one
    "friction": ("{:.3g}", 1.0),
    "payload": ("{:.3g} kg", 1.0),
    "delay": ("{:.3g} ms", 1e3),
    "motor_strength": ("{:.3g} %", 1e2),
    "sensor_noise": ("× {:.3g}", 1.0),
    "push": ("{:.3g} N s", 1.0),
}


def words(axis: str, value: float) -> str:
    """What a value is, such as ``6.25°`` or ``40 ms``."""
    if axis in TERRAINS:
        return magnitude(axis, value)
    text, factor = _WORDS[axis]
    return text.format(factor * value)


def disturbed(
    base: DisturbanceConfig,
    sensing: SensingConfig,
    axis: str,
    value: float,
    direction: float | None = None,
) -> DisturbanceConfig:
    """A disturbance with a value of an axis.

    Args:
        base: what else disturbs the robots.
        sensing: white noise, which ``sensor_noise`` multiplies.
        axis: name of the axis.
        value: in SI units.
        direction: of pushes, from forward towards left [rad].
    """
    exactly = Interval(value, value)
    if axis in TERRAINS:
        return replace(base, terrain=TerrainConfig([axis], exactly, False))  # pyright: ignore[reportArgumentType]
    if axis == "push":
        return replace(base, push=replace(base.push, impulse=exactly, direction=direction))
    if axis == "sensor_noise":
        noise = {name: value * deviation for name, deviation in vars(sensing).items()}
        return replace(base, sensing=SensingConfig(**noise))
    name = "motor_gain" if axis == "motor_strength" else axis
    return replace(base, **{name: exactly})
