"""The stages: gait → library → standing → walking → evaluation → table1 → report.

Each function lays out jobs: the part of the configuration that is a job's own, its section, and its
inputs; the entry points are in ``entries``. A section holds nothing that its stage does not use, as
it is in the recipe.

On the way to Table 1 are gaits, trainings and evaluations alone; other targets hang off these, so
that a new exporter or figure retrains no policy. The stage ``baseline`` is the evaluation of the
controllers of ``conf/control``; those that walk by gaits need the library and its foot placement.
Studies compare several configurations: ``pipeline.studies``.
"""

from pipeline.stages.entries import job
from pipeline.stages.evaluation import (
    check_walkable,
    evaluations_of,
    gait_walks,
    protocol_jobs,
    table1,
    velocity_tracking,
)
from pipeline.stages.gaits import library_job, stability_jobs, verification_jobs
from pipeline.stages.training import policy_export, training_jobs
from slider.artefacts.plan import JobSpec
from slider.config.schema import Config


def all_jobs(config: Config) -> dict[str, JobSpec]:
    """Jobs of everything but the page and what is on demand, by the name of their target."""
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
