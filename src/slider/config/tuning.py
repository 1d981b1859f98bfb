"""Typed settings of the search for settings; see ``docs/explanation/baseline.md``."""

import copy
from collections.abc import Mapping
from typing import Any

from pydantic.dataclasses import dataclass

from slider.config.types import (
    STRICT,
    Count,
    Distinct,
    MetresPerSecond,
    Number,
    Positive,
    Seed,
    Some,
)


@dataclass(frozen=True, config=STRICT)
class RangeConfig:
    """What a setting is drawn from; the present value belongs to it."""

    lower: Number
    """least value"""
    upper: Number
    """greatest value"""
    log: bool = False
    """uniform in the logarithm"""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class TuningConfig:
    """A search for each controller of ``spaces``."""

    trials: Count
    """sets of settings that are simulated; the first one is the present one"""
    sampler_seed: Seed
    """of the draws"""
    speeds: Distinct[Some[Positive[MetresPerSecond]]]
    """commanded forward velocities, of one score"""
    robots: Count
    """per speed, each with its own start; the same in all trials"""
    seed: Seed
    """of the starts"""
    spaces: dict[str, dict[str, RangeConfig]]
    """controller of ``control``, or NAME_onboard → dotted name of a number of it → range"""


def setting(control: Mapping[str, Any], name: str) -> float | None:
    """The number at a dotted name of a controller's settings, None without one."""
    value: Any = control
    for part in name.split("."):
        value = value.get(part) if isinstance(value, Mapping) else None
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return value if number else None


def with_settings(control: Mapping[str, Any], settings: Mapping[str, float]) -> dict[str, Any]:
    """A controller's settings with other numbers at dotted names that there are."""
    changed = copy.deepcopy(dict(control))
    for name, value in settings.items():
        *groups, last = name.split(".")
        place = changed
        for group in groups:
            place = place[group]
        place[last] = value
    return changed
