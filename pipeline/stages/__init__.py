"""The stages: gait → library → standing → walking → evaluation → table1 → report.

Each function creates jobs, with the part of the configuration that a job uses (its section) and its
inputs; the entry points are in ``entries``. A section is part of the recipe, so it holds only what
its stage uses.

Table 1 depends only on gaits, trainings and evaluations; other targets depend on these, so that a
new exporter or figure does not retrain a policy. The stage ``baseline`` evaluates the controllers
of ``conf/control``; those based on gaits need the library and its foot placement.
"""

from dataclasses import replace

from pipeline.stages.entries import job, origin, simulation
from pipeline.stages.evaluation import (
    check_walkable,
    evaluations_of,
    gait_walks,
    protocol_jobs,
    table1,
    velocity_tracking,
)
from pipeline.stages.gaits import library_job, stability_jobs, verification_jobs
from slider.artefacts.plan import JobSpec
from slider.artefacts.recipe import code_of
from slider.config.convert import to_dict
from slider.config.env import EnvConfig
from slider.config.schema import Config
from slider.config.train import WARP, TrainConfig
from slider.core.machine import device, precision
from slider.env.observations import TERMS
from slider.env.terms import check_clock, uses_library


def all_jobs(config: Config) -> dict[str, JobSpec]:
    """Jobs of all targets except the page and targets on demand, by name."""
    targets = table1_jobs(config)
    library = targets["library"]
    targets |= verification_jobs(config, library)
    targets |= {
        "figures": job("figures", "figures", {}, {"library": [library]}),
        "policy_export": policy_export(config.env, targets["walking"]),
        "velocity_tracking": velocity_tracking(config, targets["table1"]),
    }
    return targets | gait_walks(config, targets) | protocol_jobs(config, targets)


def table1_jobs(config: Config) -> dict[str, JobSpec]:
    """Jobs up to Table 1 by the name of their target.

    Raises:
        UserError: a controller of Table 1 cannot walk these gaits.
    """
    check_walkable(config, "evaluation.controllers", config.evaluation.controllers)
    library = library_job(config)
    trainings = training_jobs(config, library)
    jobs = {"library": library, **stability_jobs(config, library), **trainings}
    evaluations = evaluations_of(config, config.evaluation, jobs)
    return jobs | {"table1": table1(config, evaluations)}


def training_jobs(config: Config, library: JobSpec, note: str = "") -> dict[str, JobSpec]:
    """``standing``, if there is a pre-training, and ``walking``, the policy.

    With fine-tuning, ``walking`` is the fine-tuned policy and ``untuned`` the one before it. Each
    training starts from the weights of the previous one; ``note`` is appended to the labels.
    """
    jobs: dict[str, JobSpec] = {}

    def train(stage: str, label: str, settings: TrainConfig, start: JobSpec | None) -> JobSpec:
        """Job of a training, with the library as an input if the training uses it."""
        check_clock(config.env, settings, label)
        place = device(settings.device)  # resolves `auto`
        ppo = replace(settings.ppo, precision=precision(settings.ppo.precision, place))
        settings = replace(settings, device=place, ppo=ppo)
        sensed = replace(config, env=replace(config.env, sensing=settings.sensing))
        section = simulation(sensed) | {"train": to_dict(settings)}
        if settings.simulator == "mujoco_warp":
            warp = code_of(WARP)
            section["simulator"] = {"source": warp.source, "versions": warp.versions}
        inputs = {"library": [library]} if uses_library(sensed.env, settings) else {}
        return job(stage, f"{label}{note}", section, inputs | ({"start": [start]} if start else {}))

    if config.train.pretraining:
        jobs["standing"] = train("standing", "standing", config.train.standing, None)
    jobs["walking"] = train("walking", "walking", config.train.walking, jobs.get("standing"))
    if config.finetuning is not None:
        jobs["untuned"] = jobs["walking"]
        jobs["walking"] = train("walking", "fine-tuning", config.finetuning, jobs["untuned"])
    return jobs


def policy_export(env: EnvConfig, walking: JobSpec) -> JobSpec:
    """Export of the policy for use without this package; its file includes the configuration."""
    seen = walking.section["env"]["observation"]["terms"]
    # Meanings are docstrings: they are part of the layout, but not of the source digest.
    section = {
        "origin": origin(walking),
        "estimator": to_dict(env.estimator),
        "meanings": {n: TERMS[n].meaning for n in seen},
    }
    return job("policy_export", "policy export", section, {"walking": [walking]})
