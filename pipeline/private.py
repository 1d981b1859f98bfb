"""Private interfaces of Snakemake, all of them; ``tests/test_private.py`` says which one moved."""

import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from snakemake.jobs import GroupJob

_log_error = GroupJob.log_error


def keep_reasons() -> None:
    """Add the reason to the record of a failed group, as a failed job's has it."""

    def log_error(self: Any, msg: Any = None, aux_logs: Any = None, **kwargs: Any) -> None:
        _log_error(self, msg, aux_logs, rule_msg=msg, **kwargs)

    GroupJob.log_error = log_error


def needed_jobs(workflow: Any) -> dict[int, str]:
    """Number and recipe of each job of ours that is to run."""
    jobs = workflow.dag.needrun_jobs()
    return {job.jobid: job.wildcards.recipe for job in jobs if hasattr(job.wildcards, "recipe")}


def forced_recipes(workflow: Any) -> Iterator[str]:
    """Recipes of the jobs that ``-R``, ``-f`` or ``-F`` names."""
    for job in workflow.dag.needrun_jobs():
        if hasattr(job.wildcards, "recipe") and workflow.dag.reason(job).forced:
            yield job.wildcards.recipe


def pass_on(workflow: Any, setting: str, plan: Path) -> None:
    """Name the plan to the jobs, which read the Snakefile again on a cluster.

    Local ones are submitted without a limit instead, which no option lifts: each job that ends
    would start one more thread per second for it.
    """
    if workflow.local_exec:
        workflow.scheduler.job_rate_limiter = None
    else:
        settings = workflow.config_settings
        settings.config_args = [*(settings.config_args or ()), f"{setting}={plan}"]


def cancel_rest(workflow: Any) -> None:
    """Cancel cluster jobs that Snakemake lost: submitted or asked about when it is interrupted.

    All jobs of a run have its name.
    """
    name = getattr(getattr(workflow.scheduler, "_executor", None), "run_uuid", None)
    if name:
        subprocess.run(["scancel", f"--name={name}"], check=False)
