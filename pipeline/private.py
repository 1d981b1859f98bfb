"""Private interfaces of Snakemake, all of them; ``tests/test_private.py`` says which one moved."""

from collections.abc import Iterator
from typing import Any


def needed_jobs(workflow: Any) -> dict[int, str]:
    """Number and recipe of each job of ours that is to run."""
    jobs = workflow.dag.needrun_jobs()
    return {job.jobid: job.wildcards.recipe for job in jobs if hasattr(job.wildcards, "recipe")}


def forced_recipes(workflow: Any) -> Iterator[str]:
    """Recipes of the jobs that ``-R``, ``-f`` or ``-F`` names."""
    for job in workflow.dag.needrun_jobs():
        if hasattr(job.wildcards, "recipe") and workflow.dag.reason(job).forced:
            yield job.wildcards.recipe


def submit_at_once(workflow: Any) -> None:
    """Lift a limit that no option lifts: each job that ends would start a thread per second."""
    workflow.scheduler.job_rate_limiter = None
