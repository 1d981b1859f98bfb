"""Rules of seeds: what is chosen by and what is reported never use the same ones."""

from collections.abc import Sequence

from slider.config.evaluation import SeedBlock, SeedsConfig
from slider.config.schema import Config
from slider.config.studies import StudyConfig
from slider.config.train import TrainConfig
from slider.config.validation.checks import ordered, require


def check_seeds(config: Config) -> None:
    """Every evaluation is of one block; checkpoints and variants are chosen in development."""
    seeds = config.seeds
    _apart(seeds)
    for key, protocol in config.evaluations.items():
        blocks = (seeds.final, seeds.development)
        _within(f"{key}.seed", protocol.seed, protocol.trials, blocks)
    for name, study in config.study.items():
        _study(study, seeds, f"study.{name}")
    for key, train in config.trainings.items():
        _training(train, seeds, key)


def _apart(seeds: SeedsConfig) -> None:
    for name in ("final", "development"):
        block: SeedBlock = getattr(seeds, name)
        ordered(f"seeds.{name}", block.first, block.last)
    apart = seeds.final.last < seeds.development.first or seeds.development.last < seeds.final.first
    expected = f"no seed of seeds.development ({seeds.development})"
    require(apart, "seeds.final", expected, seeds.final)


def _within(key: str, first: int, trials: int, blocks: Sequence[SeedBlock]) -> None:
    """All trials draw from one of the blocks."""
    found = SeedBlock(first, first + trials - 1)
    inside = any(found.first in block and found.last in block for block in blocks)
    expected = f"seeds within {' or '.join(map(str, blocks))}"
    require(inside, key, expected, found)


def _study(study: StudyConfig, seeds: SeedsConfig, key: str) -> None:
    """Trained variants are there to be chosen from; other policies are only reported."""
    training, rollouts = study.training, study.evaluation
    if rollouts is not None:
        compared = training is not None and len(study.run) > 1
        blocks = (seeds.development,) if compared else (seeds.final, seeds.development)
        _within(f"{key}.evaluation.seed", rollouts.seed, rollouts.trials, blocks)
    for index, seed in enumerate(training.seeds if training else ()):
        _not_final(f"{key}.training.seeds[{index}]", seed, seeds)


def _training(train: TrainConfig, seeds: SeedsConfig, key: str) -> None:
    _not_final(f"{key}.seed", train.seed, seeds)
    _within(f"{key}.selection.seed", train.selection.seed, 1, (seeds.development,))


def _not_final(key: str, seed: int, seeds: SeedsConfig) -> None:
    """A training on the disturbed robots of a reported trial would know them."""
    require(seed not in seeds.final, key, f"none of seeds.final ({seeds.final})", seed)
