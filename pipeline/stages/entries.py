"""What the stages run, and jobs that do."""

from collections.abc import Mapping, Sequence
from typing import Any

from slider.artefacts.plan import JobSpec
from slider.artefacts.recipe import code_of

ENTRIES = {
    "gait": "slider.gait.stage:run",
    "gait_start": "slider.gait.random_start:run",
    "library": "slider.library.stage:run",
    "standing": "slider.training.stage:run_standing",
    "walking": "slider.training.stage:run_walking",
    "evaluation": "slider.evaluation.stage:run",
    "baseline": "slider.evaluation.stage:run_baseline",
    "table1": "slider.reports.table1:run",
    "velocity_tracking": "slider.reports.velocity_tracking:run",
    "speeds": "slider.reports.protocols.speeds:run",
    "segments": "slider.reports.protocols.segments:run",
    "cases": "slider.reports.protocols.cases:run",
    "verification_gaits": "slider.verification.stage:run_gaits",
    "verification": "slider.verification.stage:run",
    "verification_maps": "slider.reports.figures.verification_maps:run",
    "stability_gaits": "slider.hzd.stage:run_gaits",
    "foot_placement": "slider.hzd.stage:collect_placement",
    "return_maps": "slider.hzd.stability:run_maps",
    "stability": "slider.hzd.stability:run",
    "basin": "slider.hzd.stability:run_basin",
    "stability_figures": "slider.reports.figures.stability:run",
    "gait_walks": "slider.evaluation.gait_walks:run",
    "figures": "slider.reports.figures.stage:run",
    "policy_export": "slider.control.export:run",
    "ablation": "slider.reports.ablation:run",
    "sensitivity_policy": "slider.evaluation.stage:run_changed",
    "sensitivity": "slider.reports.sensitivity:run",
    "gait_convergence": "slider.reports.gait_convergence:run",
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
