"""How the head of a run looks after its jobs, and leaves nothing behind on a cluster."""

import signal
import subprocess
from pathlib import Path
from typing import Any

from pipeline.entry import PLAN


def lead(workflow: Any, plan: Path) -> None:
    """Name the plan to the jobs of a cluster, look after them, let SIGTERM do as Ctrl-C does.

    Jobs read the Snakefile anew, with the ``--config`` of the head. Those that ended are looked for
    every ``seconds-between-status-checks``: by itself the executor looks ever less often, up to
    every three minutes, and ends no sooner.
    After SIGTERM Snakemake would wait for the jobs that run.
    """
    if workflow.local_exec:
        # The limit of submissions. Each job that ends starts one more thread per second for it.
        workflow.scheduler.job_rate_limiter = None
        return
    settings = workflow.config_settings
    settings.config_args = [*(settings.config_args or ()), f"{PLAN}={plan}"]
    period = workflow.remote_execution_settings.seconds_between_status_checks
    executor = type(workflow.scheduler._executor)
    executor.next_seconds_between_status_checks = property(lambda _: period, lambda *_: None)
    signal.signal(signal.SIGTERM, signal.default_int_handler)


def cancel_the_rest(workflow: Any) -> None:
    """Cancel jobs that Snakemake lost: those that it submits or asks about when it is interrupted.

    All jobs of a run have its name.
    """
    name = getattr(getattr(workflow.scheduler, "_executor", None), "run_uuid", None)
    if name:
        subprocess.run(["scancel", f"--name={name}"], check=False)
