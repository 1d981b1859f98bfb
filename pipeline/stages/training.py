"""Pre-training, training, and the policy for others."""

from dataclasses import replace

from pipeline.stages.entries import job, origin, simulation
from slider.artefacts.plan import JobSpec
from slider.artefacts.recipe import code_of
from slider.config.convert import to_dict
from slider.config.env import EnvConfig
from slider.config.schema import Config
from slider.config.train import WARP, TrainConfig
from slider.core.machine import device, precision
from slider.env.observations import TERMS
from slider.env.terms import check_clock, uses_library


def training_jobs(config: Config, library: JobSpec, note: str = "") -> dict[str, JobSpec]:
    """``standing``, where the configuration wants it, and ``walking``, the policy.

    With a fine-tuning ``walking`` is that, and the training before it is ``untuned``.

    Args:
        config: of the trainings.
        library: for those that need it.
        note: added to the labels.
    """
    train, jobs = config.train, {}
    if train.pretraining:
        jobs["standing"] = _job(config, "standing", f"standing{note}", train.standing, library)
    jobs["walking"] = _job(
        config, "walking", f"walking{note}", train.walking, library, jobs.get("standing")
    )
    if config.finetuning is not None:
        jobs["untuned"] = jobs["walking"]
        jobs["walking"] = _job(
            config, "walking", f"fine-tuning{note}", config.finetuning, library, jobs["untuned"]
        )
    return jobs


def _job(
    config: Config,
    stage: str,
    label: str,
    train: TrainConfig,
    library: JobSpec,
    start: JobSpec | None = None,
) -> JobSpec:
    """A training from the weights of another, with the library where it uses any of it.

    Of the library the pre-training takes the clock's step times and the gaits that actions are
    about. A fine-tuning is the stage ``walking`` again, from the weights of a walk.
    """
    check_clock(config.env, train, label)
    train = _resolved(train)
    config = replace(config, env=replace(config.env, sensing=train.sensing))
    section = simulation(config) | {"train": to_dict(train)}
    if train.simulator == "mujoco_warp":
        warp = code_of(WARP)
        section["simulator"] = {"source": warp.source, "versions": warp.versions}
    inputs = {"library": [library]} if uses_library(config.env, train) else {}
    if start is not None:
        inputs["start"] = [start]
    return job(stage, label, section, inputs)


def _resolved(train: TrainConfig) -> TrainConfig:
    """Put the device and the precision that a training will have in the place of ``auto``."""
    place = device(train.device)
    ppo = replace(train.ppo, precision=precision(train.ppo.precision, place))
    return replace(train, device=place, ppo=ppo)


def policy_export(env: EnvConfig, walking: JobSpec) -> JobSpec:
    """The policy for use without this package; the policy file brings its configuration along."""
    seen = walking.section["env"]["observation"]["terms"]
    # Meanings are docstrings: they are in the layout, but in no digest of the source.
    section = {
        "origin": origin(walking),
        "estimator": None if env.onboard is None else to_dict(env.onboard.estimator),
        "meanings": {n: TERMS[n].meaning for n in seen},
    }
    return job("policy_export", "policy export", section, {"walking": [walking]})
