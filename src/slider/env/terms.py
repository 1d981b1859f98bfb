"""The terms of a configuration together: whether they exist and fit, and what they need."""

from slider.config.env import EnvConfig
from slider.config.reference import Kind, kind, kind_at
from slider.config.schema import Config
from slider.config.train import TrainConfig
from slider.core.errors import UserError
from slider.env import observations, rewards, terminations
from slider.env.declaration import Needs


def checked(config: Config) -> Config:
    """The same, if all its terms exist and take the parameters that it gives them.

    Raises:
        UserError: names the key, what was expected and what was found.
    """
    terminations.check(config.env.termination.terms, kind_at)
    observations.Observer(config.env.observation)
    for key, train in config.trainings.items():
        rewards.check(train.reward.terms, f"{key}.reward.terms", kind_at)
    return config


def kinds(config: Config) -> dict[str, Kind]:
    """What the values of the terms' parameters may be, by their keys in the configuration."""
    found = {
        f"env.termination.terms.{name}": kind(hint)
        for name in config.env.termination.terms
        for hint in terminations.TERMS[name].parameters.values()
    }
    for key, train in config.trainings.items():
        for name in train.reward.terms:
            for parameter, hint in rewards.TERMS[name].parameters.items():
                found[f"{key}.reward.terms.{name}.params.{parameter}"] = kind(hint)
    return found


def check_clock(env: EnvConfig, train: TrainConfig, label: str) -> None:
    """A training whose terms need a clock has one; an environment alone may be for others.

    Without a clock the phase is 0 for ever: terms would reward the first sample of a gait.

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
    """Step times of the clock, gaits under the action, starts on a gait, or terms that need it."""
    return (
        (env.phase.enabled and env.phase.step_time == 0)
        or env.action.offset != "nominal"
        or train.reset.reference_fraction > 0
        or any(Needs.LIBRARY in rewards.TERMS[name].needs for name in train.reward.active)
    )
