"""Whether a training needs the gait library: the pipeline makes it only for those that do."""

from slider.config.env import EnvConfig
from slider.config.train import TrainConfig

_GUIDE_TERMS = "guide_"


def uses_library(env: EnvConfig, train: TrainConfig) -> bool:
    """Step times of the clock, gaits under the action, guide terms, or starts on a gait."""
    return (
        (env.phase.enabled and env.phase.step_time == 0)
        or env.action.offset == "gait"
        or train.reset.reference_fraction > 0
        or any(name.startswith(_GUIDE_TERMS) for name in train.reward.active)
    )
