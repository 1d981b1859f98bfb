"""Entry point of each stage, and what the jobs of several stages have in common."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from slider.artefacts.plan import JobSpec
from slider.artefacts.recipe import code_of
from slider.config.convert import to_dict
from slider.config.schema import Config
from slider.core.machine import kernels

ENTRIES = {
    "gait": "slider.gait.stage:run",
    "gait_start": "slider.gait.study:run",
    "library": "slider.library.stage:run",
    "standing": "slider.training.stage:run_standing",
    "walking": "slider.training.stage:run_walking",
    "evaluation": "slider.evaluation.stage:run",
    "baseline": "slider.evaluation.stage:run_baseline",
    "gauge_axis": "slider.evaluation.gauge:run",
    "gauge": "slider.reports.gauge:run",
    "tuning": "slider.evaluation.tuning:run",
    "baseline_tuning": "slider.reports.tuning:run",
    "table1": "slider.reports.table1:run",
    "velocity_tracking": "slider.reports.protocols:run_tracking",
    "speeds": "slider.reports.protocols:run",
    "segments": "slider.reports.protocols:run",
    "cases": "slider.reports.protocols:run",
    "verification_gaits": "slider.verification.stage:run_gaits",
    "verification": "slider.verification.stage:run",
    "verification_maps": "slider.reports.figures.checks:run_verification",
    "stability_gaits": "slider.hzd.stage:run_gaits",
    "foot_placement": "slider.hzd.stage:collect_placement",
    "return_maps": "slider.hzd.stability:run_maps",
    "stability": "slider.hzd.stability:run",
    "basin": "slider.hzd.stability:run_basin",
    "stability_figures": "slider.reports.figures.checks:run_stability",
    "gait_walks": "slider.evaluation.gait_walks:run",
    "figures": "slider.reports.figures.stage:run",
    "policy_export": "slider.control.export:run",
    "policy_import": "slider.control.exported:run",
    "study": "slider.reports.study:run",
    "video": "slider.reports.video:run",
    "report": "slider.reports.page:run",
}
"""Stage → entry point ``module:function``."""


def job(
    stage: str,
    label: str,
    section: Mapping[str, Any],
    inputs: Mapping[str, Sequence[JobSpec]] | None = None,
    tracked: bool = True,
) -> JobSpec:
    """A job of a stage; the arguments are those of :class:`JobSpec`."""
    return JobSpec(stage, label, code_of(ENTRIES[stage]), section, inputs or {}, tracked)


def only(values: dict[str, Any], *names: str) -> dict[str, Any]:
    """Some of the values."""
    return {name: values[name] for name in names}


def without(values: dict[str, Any], *names: str) -> dict[str, Any]:
    """All values but some."""
    return {name: value for name, value in values.items() if name not in names}


def robot(config: Config) -> dict[str, Any]:
    """The robot; where its values come from changes no result."""
    return without(to_dict(config.robot), "provenance")


def simulation(config: Config) -> dict[str, Any]:
    """The robot and the environment of its policies, and what their networks compute with."""
    environment = replace(config.env, onboard=config.env.estimation)  # none that it does not use
    return {"robot": robot(config), "env": to_dict(environment), "numerics": kernels()}


def origin(job: JobSpec) -> dict[str, Any]:
    """Where a result comes from, for the stage that tells people."""
    return {
        "stage": job.stage,
        "label": job.label,
        "recipe": job.recipe,
        "source": job.code.source,
        "versions": job.code.versions,
    }
