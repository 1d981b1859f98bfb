"""Entry point and report files of each stage, and parts that jobs of several stages share."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from slider.artefacts.plan import JobSpec
from slider.artefacts.recipe import code_of
from slider.config.convert import to_dict
from slider.config.schema import Config
from slider.control import EXPORT_FILES
from slider.core.machine import kernels
from slider.reports.figures import FILES as FIGURES


@dataclass(frozen=True)
class Stage:
    """Entry point ``module:function`` of a stage; report files of its target in ``reports/``."""

    entry: str
    files: tuple[str, ...] = ()


def tables(name: str) -> tuple[str, ...]:
    """Files of a table that is named after its target."""
    return f"{name}.csv", f"{name}.md"


def compared(name: str) -> tuple[str, ...]:
    """Files of a table and a figure that are named after their target."""
    return *tables(name), f"figures/{name}.svg"


STAGES = {
    "gait": Stage("slider.gait.stage:run"),
    "gait_start": Stage("slider.gait.study:run"),
    "library": Stage("slider.library.stage:run"),
    "standing": Stage("slider.training.trainer:run_standing"),
    "walking": Stage("slider.training.trainer:run_walking"),
    "evaluation": Stage("slider.evaluation.stage:run"),
    "baseline": Stage("slider.evaluation.stage:run"),
    "gauge_axis": Stage("slider.evaluation.gauge:run"),
    "gauge": Stage("slider.reports.gauge:run", (*tables("gauge"), "gauge_cells.csv")),
    "drake_audit": Stage("slider.evaluation.drake:run_audit"),
    "drake_evaluation": Stage("slider.evaluation.drake:run"),
    "second_engine": Stage("slider.reports.second_engine:run", tables("second_engine")),
    "tuning": Stage("slider.evaluation.tuning:run"),
    "baseline_tuning": Stage("slider.reports.tuning:run", tables("baseline_tuning")),
    "table1": Stage(
        "slider.reports.table1:run",
        (*tables("table1"), *tables("gait_quality"), "table1.tex", "figures/tradeoff.svg"),
    ),
    "velocity_tracking": Stage(
        "slider.reports.protocols:run_tracking", compared("velocity_tracking")
    ),
    "speeds": Stage("slider.reports.protocols:run"),
    "segments": Stage("slider.reports.protocols:run"),
    "cases": Stage("slider.reports.protocols:run"),
    "verification_gaits": Stage("slider.verification.stage:run_gaits"),
    "verification": Stage("slider.verification.stage:run", tables("verification")),
    "stability_gaits": Stage("slider.hzd.stage:run_gaits"),
    "foot_placement": Stage("slider.hzd.stage:collect_placement"),
    "stability": Stage("slider.hzd.stability:run", tables("stability")),
    "gait_walks": Stage("slider.evaluation.gait_walks:run", tables("gait_walks")),
    "figures": Stage(
        "slider.reports.figures.stage:run", tuple(f"figures/{name}" for name in FIGURES)
    ),
    "policy_export": Stage(
        "slider.control.export:run", tuple(f"policy/{name}" for name in EXPORT_FILES)
    ),
    "policy_import": Stage("slider.control.exported:run"),
    "study": Stage("slider.reports.study:run"),
    "video": Stage("slider.reports.video:run"),
    "report": Stage("slider.reports.page:run", ("index.html",)),
}
"""Stages by name; each is a rule of Snakemake."""


def job(
    stage: str,
    label: str,
    section: Mapping[str, Any],
    inputs: Mapping[str, Sequence[JobSpec]] | None = None,
    tracked: bool = True,
) -> JobSpec:
    """A job of a stage; the arguments are those of :class:`JobSpec`."""
    return JobSpec(stage, label, code_of(STAGES[stage].entry), section, inputs or {}, tracked)


def only(values: dict[str, Any], *names: str) -> dict[str, Any]:
    """The values with the given names."""
    return {name: values[name] for name in names}


def without(values: dict[str, Any], *names: str) -> dict[str, Any]:
    """All values except those with the given names."""
    return {name: value for name, value in values.items() if name not in names}


def robot(config: Config) -> dict[str, Any]:
    """The robot without provenance, which does not affect results."""
    return without(to_dict(config.robot), "provenance")


def simulation(config: Config) -> dict[str, Any]:
    """The robot, the environment of its policies, and the kernels of the numerical libraries."""
    environment = replace(config.env, onboard=config.env.estimation)  # None where it is not used
    return {"robot": robot(config), "env": to_dict(environment), "numerics": kernels()}


def origin(job: JobSpec) -> dict[str, Any]:
    """Origin of a result, for stages that report it."""
    return {
        "stage": job.stage,
        "label": job.label,
        "recipe": job.recipe,
        "source": job.code.source,
        "versions": job.code.versions,
    }
