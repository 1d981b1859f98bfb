"""How the head of a run looks after its jobs, and leaves nothing behind on a cluster."""

import signal
import subprocess
from pathlib import Path
from typing import Any

from pipeline.entry import PLAN


def lead(workflow: Any, plan: Path) -> None:
    """Name the plan to the jobs of a cluster, and let SIGTERM do as Ctrl-C does.

    Jobs read the Snakefile again, with the ``--config`` of the head. After SIGTERM Snakemake alone
    would wait for the jobs that run.
    """
    if workflow.local_exec:
        # The limit of submissions. Each job that ends starts one more thread per second for it.
        workflow.scheduler.job_rate_limiter = None
        return
    settings = workflow.config_settings
    settings.config_args = [*(settings.config_args or ()), f"{PLAN}={plan}"]
    signal.signal(signal.SIGTERM, signal.default_int_handler)


def cancel_rest(workflow: Any) -> None:
    """Cancel jobs that Snakemake lost: those that it submits or asks about when it is interrupted.

    All jobs of a run have its name.
    """
    name = getattr(getattr(workflow.scheduler, "_executor", None), "run_uuid", None)
    if name:
        subprocess.run(["scancel", f"--name={name}"], check=False)
