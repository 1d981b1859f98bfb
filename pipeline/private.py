"""All private interfaces of Snakemake in use; ``tests/test_private.py`` finds those that change."""

from collections.abc import Iterator
from typing import Any


def needed_jobs(workflow: Any) -> dict[int, str]:
    """Snakemake's job number → recipe of each stage job that is to run."""
    jobs = workflow.dag.needrun_jobs()
    return {job.jobid: job.wildcards.recipe for job in jobs if hasattr(job.wildcards, "recipe")}


def forced_recipes(workflow: Any) -> Iterator[str]:
    """Recipes of the jobs that ``-R``, ``-f`` or ``-F`` force to run."""
    for job in workflow.dag.needrun_jobs():
        if hasattr(job.wildcards, "recipe") and workflow.dag.reason(job).forced:
            yield job.wildcards.recipe


def submit_at_once(workflow: Any) -> None:
    """Remove the job rate limit, which no option disables: it starts timer threads for each job."""
    workflow.scheduler.job_rate_limiter = None
