"""How the head of a run on a cluster looks after its jobs, and leaves nothing behind."""

import signal
import subprocess
from pathlib import Path
from typing import Any

from pipeline.entry import PLAN


def hand_on(workflow: Any, plan: Path) -> None:
    """Name the head's plan in the ``--config`` of jobs, which read the Snakefile anew."""
    settings = workflow.config_settings
    settings.config_args = [*(settings.config_args or ()), f"{PLAN}={plan}"]


def watch_cluster(workflow: Any) -> None:
    """Look for ended jobs every ``seconds-between-status-checks``; let SIGTERM do as Ctrl-C does.

    By itself the executor looks ever less often, up to every three minutes, and ends no sooner;
    after SIGTERM Snakemake would wait for the jobs that run.
    """
    if workflow.local_exec:
        return
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
