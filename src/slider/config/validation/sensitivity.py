"""Checks of the sensitivity's settings."""

from collections.abc import Sequence

from slider.config.parameters import Parameter, choose, parameters
from slider.config.schema import Config
from slider.config.sensitivity import SensitivityConfig
from slider.config.validation.checks import (
    at_least,
    distinct,
    one_of,
    period,
    require,
    some,
)

KEY = "sensitivity"


def check_sensitivity(config: Config) -> None:
    """A change that leaves signs alone, parameters that there are, and something to look at."""
    settings = config.sensitivity
    expected = "a share in (0, 1), both excluded"
    require(0 < settings.change < 1, f"{KEY}.change", expected, settings.change)
    _parameters(settings, parameters(config.robot))
    some(f"{KEY}.commands", settings.commands, "command")
    distinct(f"{KEY}.commands", settings.commands, "each once")
    at_least(f"{KEY}.robots", settings.robots, 1)
    steady, end = settings.warm_up, settings.duration
    period(f"{KEY}.warm_up", steady, end, config.env.control_period)
    expected = "one of gaits and policy true"
    require(settings.gaits or settings.policy, KEY, expected, "both false")


def _parameters(settings: SensitivityConfig, found: Sequence[Parameter]) -> None:
    some(f"{KEY}.provenance", settings.provenance, "tag")
    known = dict.fromkeys(item.provenance for item in found)
    for tag in settings.provenance:
        one_of(f"{KEY}.provenance", tag, known)
    tags = " or ".join(settings.provenance)
    expected = f"numbers of the robot tagged {tags}"
    for path in settings.parameters:
        chosen = choose(found, settings.provenance, [path])
        require(len(chosen) > 0, f"{KEY}.parameters", expected, path)
