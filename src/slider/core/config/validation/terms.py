"""Checks of the terms of observations, rewards and terminations: names, parameters, a clock."""

from collections.abc import Iterable, Mapping

from slider.core.config.env import EnvConfig
from slider.core.config.train import TrainConfig
from slider.core.config.validation.checks import require
from slider.core.errors import UserError
from slider.env import terminations
from slider.env.observations import Observer
from slider.env.rewards import Reward

# Without a clock the phase is 0 for ever: they would reward the first sample of a gait.
_CLOCKED = ("contact_schedule", "guide_phase", "guide_phase_turning", "guide_height", "phase")


def check_terms(env: EnvConfig, trainings: Mapping[str, TrainConfig]) -> None:
    """Terms that exist, with the parameters that they take; trainings by their keys."""
    terminations.check(env.termination.terms)
    Observer(env.observation)
    _clocked("env.observation.terms", env.observation.terms, env)
    for key, train in trainings.items():
        try:
            Reward(train.reward)
        except UserError as error:
            raise UserError(f"{key}.{error}") from None
        _clocked(f"{key}.reward.terms", train.reward.terms, env)


def _clocked(key: str, names: Iterable[str], env: EnvConfig) -> None:
    for name in names:
        possible = env.phase.enabled or name not in _CLOCKED
        require(possible, key, f"env.phase.enabled for {name}", "no clock")
