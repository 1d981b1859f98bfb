"""Checks of the ablation's settings."""

from slider.config.ablation import AblationConfig
from slider.config.validation.checks import all_at_least, at_least, distinct, one_of, require


def check_ablation(ablation: AblationConfig) -> None:
    """Known variants, and something to train and to evaluate."""
    key, expected = "ablation", "one or more, each once"
    for name in ablation.run:
        one_of(f"{key}.run", name, ablation.variants)
    for name in ("run", "seeds", "commands"):
        values = getattr(ablation, name)
        require(len(values) > 0, f"{key}.{name}", expected, values)
        distinct(f"{key}.{name}", values, expected)
    for index, seed in enumerate(ablation.seeds):
        at_least(f"{key}.seeds[{index}]", seed, 0)
    counts = ("samples", "pretraining_samples", "check_every", "trials", "robots")
    all_at_least(key, ablation, counts, 1)
