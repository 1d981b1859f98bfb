"""Studies: gaits, trainings and evaluations of several variants, compared by metrics.

A variant is the configuration of the pipeline with further overrides. Its jobs are ordinary ones:
shared results are computed once, and a further variant or seed adds only its own jobs.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pipeline.stages import training_jobs
from pipeline.stages.entries import job
from pipeline.stages.evaluation import (
    base_of,
    check_walkable,
    evaluations_of,
    labels,
    speed_of,
)
from pipeline.stages.gaits import gait, gait_section, library_job, stability_jobs
from slider.artefacts.plan import JobSpec
from slider.composition.compose import compose
from slider.config.control import POLICY
from slider.config.convert import to_dict
from slider.config.evaluation import EvaluationConfig
from slider.config.parameters import choose, parameters, scaled
from slider.config.schema import BudgetConfig, Config, StudyConfig
from slider.config.train import TrainConfig
from slider.config.validation import validate
from slider.core.errors import UserError, one_of, require
from slider.env.terms import checked
from slider.reports.quantities import GAIT_QUANTITIES, QUANTITIES

GAITS_ONLY = ("virtual_knee",)
"""Parts of the robot that only gaits depend on; the simulation does not use them."""
STARTS = "_starts"
"""Suffix of the row of a variant's gaits from random initial guesses."""
Keyed = tuple[str, list[Any], JobSpec]
"""Name of the input; variant, seed, and speed [m/s] or samples per iteration; the job."""


@dataclass(frozen=True)
class Variant:
    """A row of a study; if ``config`` is None, ``note`` gives the reason."""

    name: str
    label: str
    changes: str
    config: Config | None = None
    note: str = ""


def study_job(
    name: str,
    config: Config,
    targets: Mapping[str, JobSpec],
    overrides: Sequence[str],
    conf: Path,
) -> JobSpec:
    """Jobs of all variants, and the comparison of their results.

    Of the pipeline's ``targets``, ``library`` and ``walking`` are used. ``config`` was composed
    from the folder ``conf`` with the ``overrides``.

    Raises:
        UserError: an unknown metric, or the overrides of a variant do not compose.
    """
    study, key = config.study[name], f"study.{name}"
    rolled_out = study.evaluation is not None
    metrics = [n for n in QUANTITIES if (study.gaits if n in GAIT_QUANTITIES else rolled_out)]
    for metric in study.metrics:
        one_of(f"{key}.metrics", metric, metrics)
    controllers = study.evaluation.controllers if study.evaluation else []
    variants = list(_variants(config, study, overrides, conf, key))
    if study.training is not None:
        tuned = [v.name for v in variants if v.config and v.config.finetuning]
        require(not tuned, f"{key}.training", "variants without finetuning", ", ".join(tuned))
    keyed = [item for variant in variants for item in _jobs(variant, study, config, targets)]
    inputs: dict[str, list[JobSpec]] = {}
    keys: dict[str, list[list[Any]]] = {}
    for group, place, spec in keyed:
        inputs.setdefault(group, []).append(spec)
        keys.setdefault(group, []).append(place)
    if study.training is not None:
        inputs["library"] = [targets["library"]]
    others = labels(config, (name for name in controllers if name != POLICY))
    rows = [(v.name, v.label, v.changes, v.note) for v in variants]
    for other, label in others.items():
        rows += [(f"{v.name}_{other}", f"{v.label}, {label}", "", "") for v in variants if v.config]
    if study.starts is not None:
        rows += [(f"{v.name}{STARTS}", f"{v.label}, random starts", "", "") for v in variants]
    section = {
        "name": name,
        "robot": config.robot.name,
        "metrics": study.metrics,
        "variants": rows,
        "keys": keys,
        "max_violation": config.library.max_violation,
        "same_cost": study.starts.same_cost if study.starts else None,
    }
    return job("study", name, section, inputs)


def _variants(
    config: Config, study: StudyConfig, overrides: Sequence[str], conf: Path, key: str
) -> Iterator[Variant]:
    for name in study.run:
        variant = study.variants[name]
        try:
            changed = checked(compose([*overrides, *variant.overrides], conf))
        except UserError as error:
            raise UserError(f"{key}.variants.{name}: {error}") from None
        yield Variant(name, variant.label, " ".join(variant.overrides), changed)
    if study.scaling is None:
        return
    scaling = study.scaling
    items, tags = parameters(config.robot), scaling.provenance
    expected = f"numbers of the robot tagged {' or '.join(tags)}"
    require(bool(choose(items, tags, [])), f"{key}.scaling", expected, "none")
    for path in scaling.parameters:
        require(bool(choose(items, tags, [path])), f"{key}.scaling.parameters", expected, path)
    for item in choose(items, tags, scaling.parameters):
        if not any(item.value):
            continue  # scaling does not change zero
        for factor in (round(1 + sign * scaling.change, 10) for sign in (-1, 1)):
            yield _scaled(config, item.path, item.value, factor)


def _scaled(config: Config, path: str, value: Sequence[float], factor: float) -> Variant:
    """Variant with one parameter scaled; without a configuration if that robot is invalid."""
    text = ",".join(f"{number * factor:.6g}" for number in value)
    changes = f"robot.{path}={f'[{text}]' if len(value) > 1 else text}"
    variant = Variant(f"{path}*{factor:g}", f"{path} × {factor:g}", changes)
    try:
        changed = replace(config, robot=scaled(config.robot, path, factor))
        validate(changed)
    except UserError as error:
        return replace(variant, note=f"invalid robot: {error}")
    return replace(variant, config=changed)


def _jobs(
    variant: Variant, study: StudyConfig, config: Config, targets: Mapping[str, JobSpec]
) -> Iterator[Keyed]:
    """All jobs of a variant whose results are compared."""
    changed, note = variant.config, f" ({variant.name})"
    if changed is None:
        return
    if study.gaits:
        yield from _gaits(variant, changed, study)
    if study.evaluation is None:
        return
    own = {"speeds": study.speeds, "profile": None}
    protocol = replace(changed.evaluation, **own, **to_dict(study.evaluation))
    policies = [name for name in protocol.controllers if base_of(name) == POLICY]
    baselines = [name for name in protocol.controllers if name not in policies]
    if baselines:
        check_walkable(changed, "evaluation.controllers", baselines)
        library = library_job(changed)
        jobs = {"library": library, **stability_jobs(changed, library)}
        walks = replace(protocol, controllers=baselines)
        yield from _evaluations(variant, "", changed, walks, jobs, note)
    protocol = replace(protocol, controllers=policies)
    if study.training is None:
        unused = {name: getattr(config.robot, name) for name in GAITS_ONLY}
        plant = replace(changed, robot=replace(changed.robot, **unused))
        yield from _evaluations(variant, "", plant, protocol, targets, note)
        return
    library, budget, train = library_job(changed), study.training, changed.train
    for seed in budget.seeds:
        note = f" ({variant.name}, seed {seed})"
        standing = _trained(train.standing, budget.pretraining_samples, budget, seed)
        walking = _trained(train.walking, budget.samples, budget, seed)
        trainings = replace(train, standing=standing, walking=walking)
        trained = replace(changed, train=trainings)
        jobs = {"walking": training_jobs(trained, library, note)["walking"]}
        yield "walking", [variant.name, seed, _batch(walking)], jobs["walking"]
        yield from _evaluations(variant, seed, trained, protocol, jobs, note)


def _evaluations(
    variant: Variant,
    seed: int | str,
    config: Config,
    protocol: EvaluationConfig,
    jobs: Mapping[str, JobSpec],
    note: str,
) -> Iterator[Keyed]:
    """Evaluations; row VARIANT for the policy, row VARIANT_CONTROLLER for other controllers."""
    for spec in evaluations_of(config, protocol, jobs, note):
        controller = spec.section["controller"]
        row = variant.name if controller == POLICY else f"{variant.name}_{controller}"
        yield "evaluations", [row, seed, speed_of(spec)], spec


def _gaits(variant: Variant, config: Config, study: StudyConfig) -> Iterator[Keyed]:
    """Gaits solved from the guesses of ``gait.solver``, and from each random guess separately."""
    shared, starts = gait_section(config), study.starts
    for speed in study.speeds:
        solved = gait(shared, (speed, 0.0, 0.0))
        label = f"{solved.label} ({variant.name})"
        yield "gaits", [variant.name, "", speed], replace(solved, label=label)
        if starts is None:
            continue
        for index in range(starts.count):
            start = {"seed": starts.seed, "index": index, "spread": to_dict(starts.spread)}
            section = shared | {"velocity": [speed, 0.0, 0.0], "start": start}
            label = f"gait {speed:.2f} m/s from start {index}"
            place = [f"{variant.name}{STARTS}", index, speed]
            yield "gaits", place, job("gait_start", label, section, tracked=False)


def _trained(train: TrainConfig, samples: int, budget: BudgetConfig, seed: int) -> TrainConfig:
    """Training of about ``samples`` environment steps, checked every ``budget.check_every``."""
    iterations = max(1, round(samples / _batch(train)))
    interval = max(1, round(budget.check_every / _batch(train)))
    selection = replace(train.selection, interval=interval)
    return replace(train, iterations=iterations, seed=seed, selection=selection)


def _batch(train: TrainConfig) -> int:
    """Number of samples per iteration."""
    return train.robots * train.steps_per_iteration
