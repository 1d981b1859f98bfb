"""Typed settings of the ablation: what is compared, at what cost."""

from pydantic.dataclasses import dataclass

from slider.config.strict import STRICT


@dataclass(frozen=True, config=STRICT)
class VariantConfig:
    """One row of the ablation: what people call it, and Hydra overrides of the configuration."""

    label: str
    overrides: list[str]


@dataclass(frozen=True, config=STRICT)
class AblationConfig:
    """Variants that are trained, how long, how often, and where they are evaluated.

    ``samples`` [control steps of a robot] are those of a walking training, ``pretraining_samples``
    those of standing; after every ``check_every`` of them the policy is judged. ``seeds`` are those
    of the trainings, ``evaluation_seed`` that of the first trial of the evaluations.
    """

    run: list[str]
    seeds: list[int]
    samples: int
    pretraining_samples: int
    check_every: int
    commands: list[float]
    trials: int
    robots: int
    evaluation_seed: int
    variants: dict[str, VariantConfig]
