"""The terms of a configuration together: whether they exist and fit, and what they need."""

from slider.config.env import EnvConfig
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
    terminations.check(config.env.termination.terms)
    observations.Observer(config.env.observation)
    rewards.check(config.train.standing.reward.terms, "train.standing.reward.terms")
    rewards.check(config.train.walking.reward.terms, "train.walking.reward.terms")
    if config.finetuning is not None:
        rewards.check(config.finetuning.reward.terms, "finetuning.reward.terms")
    return config


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
        or env.action.offset == "gait"
        or train.reset.reference_fraction > 0
        or any(Needs.LIBRARY in rewards.TERMS[name].needs for name in train.reward.active)
    )
