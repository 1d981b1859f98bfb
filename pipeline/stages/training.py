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
    """``standing``, if there is a pre-training, and ``walking``, the policy.

    With a fine-tuning ``walking`` is that, and the training before it is ``untuned``. Each begins
    with the weights of the one before; ``note`` is added to the labels.
    """
    jobs: dict[str, JobSpec] = {}

    def train(stage: str, label: str, settings: TrainConfig, start: JobSpec | None) -> JobSpec:
        """A training, with the library where it uses any of it."""
        check_clock(config.env, settings, label)
        place = device(settings.device)  # in the place of `auto`
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
    """The policy for use without this package; the policy file brings its configuration along."""
    seen = walking.section["env"]["observation"]["terms"]
    # Meanings are docstrings: they are in the layout, but in no digest of the source.
    section = {
        "origin": origin(walking),
        "estimator": None if env.onboard is None else to_dict(env.onboard.estimator),
        "meanings": {n: TERMS[n].meaning for n in seen},
    }
    return job("policy_export", "policy export", section, {"walking": [walking]})
