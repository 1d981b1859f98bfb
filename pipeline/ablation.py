"""The ablation: the same trainings and evaluations for several configurations, side by side.

A variant is the configuration of the pipeline with some overrides more. Its gaits, trainings and
evaluations are ordinary jobs: what two variants have in common is computed once, what was
computed before is not computed again, and a killed training goes on where it was.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pipeline.stages.entries import job
from pipeline.stages.evaluation import evaluations_of
from pipeline.stages.gaits import library_job
from pipeline.stages.training import training_jobs
from slider.artefacts.plan import JobSpec
from slider.config.compose import compose
from slider.config.control import POLICY
from slider.config.convert import to_dict
from slider.config.schema import Config
from slider.config.studies import AblationConfig, VariantConfig
from slider.config.train import TrainConfig
from slider.core.errors import UserError
from slider.env.terms import checked


def ablation_job(
    config: Config,
    library: JobSpec,
    overrides: Sequence[str],
    conf: Path,
    reports: str = "ablation",
) -> JobSpec:
    """The comparison of all variants; each takes half a second to compose for the first time.

    Args:
        config: configuration of the pipeline.
        library: its gaits, with whose sway the variants' is compared.
        overrides: with which ``config`` was composed.
        conf: folder of the configuration.
        reports: name of its files.

    Raises:
        UserError: the overrides of a variant do not compose.
    """
    settings = config.ablation
    runs: list[dict[str, Any]] = []
    walking: list[JobSpec] = []
    evaluations: list[JobSpec] = []
    for name in settings.run:
        variant = _compose(name, settings.variants[name], overrides, conf)
        gaits = library_job(variant)
        for seed in settings.seeds:
            own, note = _with_budget(variant, settings, seed), f" ({name}, seed {seed})"
            walking.append(training_jobs(own, gaits, note)["walking"])
            evaluations += evaluations_of(own, own.evaluation, {"walking": walking[-1]}, note)
            runs.append({"variant": name, "seed": seed, "batch": _batch(own.train.walking)})
    section = {
        "name": reports,
        "runs": runs,
        "commands": settings.commands,
        "variants": {name: to_dict(settings.variants[name]) for name in settings.run},
    }
    inputs = {"library": [library], "walking": walking, "evaluations": evaluations}
    return job("ablation", reports, section, inputs)


def _compose(name: str, variant: VariantConfig, overrides: Sequence[str], conf: Path) -> Config:
    try:
        return checked(compose([*overrides, *variant.overrides], conf))
    except UserError as error:
        raise UserError(f"ablation.variants.{name}: {error}") from None


def _with_budget(config: Config, settings: AblationConfig, seed: int) -> Config:
    """One seed of a variant with the samples and the protocol of the ablation, not fine-tuned."""
    train = replace(
        config.train,
        standing=_trained(config.train.standing, settings.pretraining_samples, settings, seed),
        walking=_trained(config.train.walking, settings.samples, settings, seed),
    )
    evaluation = replace(
        config.evaluation,
        controllers=[POLICY],
        commands=settings.commands,
        trials=settings.trials,
        robots=settings.robots,
        seed=settings.evaluation_seed,
    )
    return replace(config, train=train, finetuning=None, evaluation=evaluation)


def _trained(train: TrainConfig, samples: int, settings: AblationConfig, seed: int) -> TrainConfig:
    """A training of so many samples, in whole iterations, judged at even distances."""
    interval = max(1, round(settings.check_every / _batch(train)))
    return replace(
        train,
        iterations=max(1, round(samples / _batch(train))),
        seed=seed,
        selection=replace(train.selection, interval=interval),
    )


def _batch(train: TrainConfig) -> int:
    """Samples of one iteration."""
    return train.gpus * train.robots * train.steps_per_iteration
