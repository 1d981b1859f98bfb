"""Fewer lines while the pipeline runs: every job says itself, in one line, that it is done.

On a cluster a job speaks into Slurm's log. There this module speaks for it.
"""

import logging
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from snakemake.jobs import GroupJob
from snakemake.logging import logger
from snakemake_interface_logger_plugins.common import LogEvent

_TEXTS = (
    *("Select jobs to execute...", "Execute "),
    # Slurm's default account is one, too.
    *("No SLURM account given", "No account was given", "Unable to guess SLURM account"),
)
_TAIL = 5  # lines of the log of a job that could not speak for itself
_SPOKE = re.compile(r"^(Traceback \(most recent call last\)|slider: )", re.MULTILINE)
_REASON_ENDS = re.compile(r"\n +sbatch call|Detailed failure reason|For further error details")


def calm(workflow: Any) -> None:
    """Drop the four lines that Snakemake's scheduler writes per job; errors stay."""
    logger.addFilter(lambda record: _is_news(record, remote=not workflow.local_exec))
    _keep_reasons()


def _keep_reasons() -> None:
    """Let the error of a group of jobs say why, as that of a job does."""
    plain = GroupJob.log_error

    def log_error(self: Any, msg: Any = None, aux_logs: Any = None, **kwargs: Any) -> None:
        plain(self, msg, aux_logs, rule_msg=msg, **kwargs)

    GroupJob.log_error = log_error


def _is_news(record: logging.LogRecord, remote: bool) -> bool:
    event, facts = getattr(record, "event", None), vars(record)
    if event == LogEvent.GROUP_ERROR:
        _show_failure(facts, facts["job_error_info"], facts["aux_logs"])
    if event == LogEvent.JOB_ERROR and remote and not facts["indent"]:  # else of a group
        own, others = facts["log"][:1], facts["log"][1:]
        _show_failure(facts, [facts | {"log": own}], others)
    elif event == LogEvent.JOB_ERROR and not remote:
        for log in map(Path, facts["log"]):
            if not _SPOKE.search(_read(log)):  # a killed job: Snakemake keeps quiet about it
                _show_log(log)
    if event == LogEvent.JOB_FINISHED or (event == LogEvent.PROGRESS and not remote):
        return False
    return not record.getMessage().startswith(_TEXTS)


def _show_failure(
    facts: Mapping[str, Any], jobs: list[dict[str, Any]], cluster_logs: list[str]
) -> None:
    """Say what a cluster says of a submission, and the last words of those of its jobs that failed.

    Where none of them came to write a log, the cluster's own log stands in.
    """
    reason = _REASON_ENDS.split(facts.get("rule_msg") or "")[0].strip()
    if reason:
        print(f"slider: {reason}", file=sys.stderr)
    failed = [job for job in jobs if not all(Path(name).exists() for name in job["output"])]
    logs = [log for job in failed for log in map(Path, job["log"]) if log.is_file()]
    for log in logs or map(Path, cluster_logs):
        _show_log(log)


def _show_log(log: Path) -> None:
    """Say where a log is and how it ends."""
    last = [line for line in _read(log).splitlines() if line.strip()][-_TAIL:]
    end = "".join(f"\n  {line}" for line in last)
    print(f"slider: the job's log is {log}{end}", file=sys.stderr)


def _read(log: Path) -> str:
    return log.read_text(encoding="utf-8", errors="replace") if log.is_file() else ""
