"""Pre-training, training, and the policy for others."""

from pipeline.stages.entries import job
from pipeline.stages.sections import origin, simulation
from slider.core.config.convert import to_dict
from slider.core.config.library_use import uses_library
from slider.core.config.schema import Config
from slider.core.plan import JobSpec


def training_jobs(config: Config, library: JobSpec, note: str = "") -> dict[str, JobSpec]:
    """``standing``, where the configuration wants it, and ``walking``.

    Args:
        config: of the trainings.
        library: for those that need it.
        note: added to the labels.
    """
    if not config.train.pretraining:
        return {"walking": walking_training(config, library, None, note)}
    standing = standing_training(config, library, note)
    return {"standing": standing, "walking": walking_training(config, library, standing, note)}


def standing_training(config: Config, library: JobSpec, note: str = "") -> JobSpec:
    """Pre-training; of the library it needs the step times of the clock at most."""
    train = config.train.standing
    section = simulation(config) | {"train": to_dict(train)}
    inputs = {"library": [library]} if uses_library(config.env, train) else {}
    return job("standing", f"standing{note}", section, inputs)


def walking_training(
    config: Config, library: JobSpec, standing: JobSpec | None, note: str = ""
) -> JobSpec:
    """Training from the standing policy and guided by the library, where there are these."""
    train = config.train.walking
    section = simulation(config) | {"train": to_dict(train)}
    inputs = {"library": [library]} if uses_library(config.env, train) else {}
    if standing is not None:
        inputs["standing"] = [standing]
    return job("walking", f"walking{note}", section, inputs)


def policy_export(walking: JobSpec) -> JobSpec:
    """The policy for use without this package; the policy file brings its configuration along."""
    inputs = {"walking": [walking]}
    return job("policy_export", "policy export", {"origin": origin(walking)}, inputs)
