"""Checks of the terms of observations, rewards and terminations: names, parameters, clock."""

from collections.abc import Mapping

from slider.config.env import EnvConfig
from slider.config.train import TrainConfig
from slider.config.validation.checks import require
from slider.core.errors import UserError
from slider.env import terminations
from slider.env.observations import Observer
from slider.env.rewards import Reward

# Without a clock the phase is 0 for ever: they would reward the first sample of a gait.
_CLOCKED = {"contact_schedule", "guide_phase", "guide_phase_turning", "guide_height", "phase"}


def check_terms(env: EnvConfig, trainings: Mapping[str, TrainConfig]) -> None:
    """Terms that exist, with the parameters that they take; trainings by their keys."""
    terminations.check(env.termination.terms)
    Observer(env.observation)
    for key, train in trainings.items():
        try:
            Reward(train.reward)
        except UserError as error:
            raise UserError(f"{key}.{error}") from None


def check_clock(env: EnvConfig, train: TrainConfig, label: str) -> None:
    """A training whose terms ask for a clock has one; an environment alone may be for others.

    Raises:
        UserError: names the term.
    """
    for key, names in (("env.observation", env.observation.terms), ("reward", train.reward.active)):
        for name in sorted(_CLOCKED.intersection(names)):
            expected = f"env.phase.enabled for {name}"
            require(env.phase.enabled, f"{label}: {key}.terms", expected, "no clock")
