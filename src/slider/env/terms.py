"""Checks of all terms of a configuration, and what they require of a training."""

from typing import Any

from slider.config.env import EnvConfig
from slider.config.schema import Config
from slider.config.train import TrainConfig
from slider.core.errors import UserError
from slider.env import observations, rewards, terminations
from slider.env.declaration import Needs


def checked(config: Config) -> Config:
    """Return the configuration if all its terms exist and their parameters are valid.

    Raises:
        UserError: names the key, what was expected and what was found.
    """
    terminations.check(config.env.termination.terms)
    observations.Observer(config.env.observation, config.robot.geometry)
    for key, train in config.trainings.items():
        rewards.check(train.reward.terms, f"{key}.reward.terms")
    return config


def parameter_types(config: Config) -> dict[str, Any]:
    """Types of the terms' parameters by their keys in the configuration."""
    result = {
        f"env.termination.terms.{name}": hint
        for name in config.env.termination.terms
        for hint in terminations.TERMS[name].parameters.values()
    }
    for key, train in config.trainings.items():
        for name in train.reward.terms:
            for parameter, hint in rewards.TERMS[name].parameters.items():
                result[f"{key}.reward.terms.{name}.params.{parameter}"] = hint
    return result


def check_clock(env: EnvConfig, train: TrainConfig, label: str) -> None:
    """Refuse a training without a clock whose terms need one.

    Without a clock the phase stays 0: terms would always reward the first sample of a gait.

    Raises:
        UserError: names the term.
    """
    if env.phase.enabled:
        return
    for key, terms, names in (
        ("env.observation", observations.TERMS, env.observation.terms),
        ("reward", rewards.TERMS, train.reward.active),
    ):
        for name in sorted(name for name in names if Needs.CLOCK in terms[name].needs):
            expected = f"env.phase.enabled for {name}"
            raise UserError(f"{label}: {key}.terms: expected {expected}, found no clock")


def uses_library(env: EnvConfig, train: TrainConfig) -> bool:
    """Whether step times, actions, starts or terms of a training need the gait library."""
    return (
        (env.phase.enabled and env.phase.step_time == 0)
        or env.action.offset != "nominal"
        or train.reset.reference_fraction > 0
        or any(Needs.LIBRARY in rewards.TERMS[name].needs for name in train.reward.active)
    )
