"""What Snakemake says while the pipeline runs: errors. Jobs and progress say the rest."""

import logging
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from snakemake.logging import logger
from snakemake_interface_logger_plugins.common import LogEvent

from pipeline.progress import Needed, Progress, forecast
from slider.artefacts.plan import Plan
from slider.artefacts.store import Store

_EVENTS = (LogEvent.JOB_STARTED, LogEvent.JOB_FINISHED, LogEvent.PROGRESS)
_OF_A_RUN = (LogEvent.RUN_INFO, LogEvent.RESOURCES_INFO)  # of a dry run they are the answer
_TEXTS = ("Select jobs to execute...", "Assuming unrestricted", "Building DAG", "Using shell")
_AT_THE_END = ("Complete log", "Elapsed time")
_TAIL = 5  # lines of the log of a job that could not speak for itself
_SHOWN = "Traceback (most recent call last)"  # such a job has shown the end of its log itself


@dataclass
class Console:
    """Takes the records of Snakemake's logger: drops chatter, follows jobs, lets errors pass."""

    workflow: Any
    progress: Progress | None = None
    succeeded: bool = False

    def __post_init__(self) -> None:
        self._recipes: dict[int, str] = {}
        logger.addFilter(self._is_news)

    def open(self, plan: Plan, store: Store) -> None:
        """Begin to show the progress of the jobs that Snakemake is about to run."""
        with self._harmless():
            self._open(plan, store)

    def _open(self, plan: Plan, store: Store) -> None:
        jobs = [job for job in self.workflow.dag.needrun_jobs() if hasattr(job.wildcards, "recipe")]
        self._recipes = {job.jobid: job.wildcards.recipe for job in jobs}
        needed = [Needed(job.wildcards.recipe, job.priority, job.threads) for job in jobs]
        settings = self.workflow.resource_settings
        cores = settings.cores or settings.nodes or 1
        if needed:
            self.progress = Progress(plan, store, forecast(plan, store, needed, cores))
            self.progress.open(cores)

    def close(self, succeeded: bool) -> None:
        """End the lines about running jobs."""
        self.succeeded = succeeded
        with self._harmless():
            if self.progress is not None:
                self.progress.close(succeeded)

    @contextmanager
    def _harmless(self) -> Iterator[None]:
        """Who shows a run must not end it: after an error nothing more is shown."""
        try:
            yield
        except Exception:
            traceback.print_exc()
            if self.progress is not None:
                self.progress.hush()
            self.progress = None

    def _is_news(self, record: logging.LogRecord) -> bool:
        event = getattr(record, "event", None)
        if event == LogEvent.JOB_ERROR:
            _point_to_log(getattr(record, "log", None) or [])
        if event in _EVENTS:
            self._follow(event, record)
            return False
        if event in _OF_A_RUN:
            return self.workflow.dryrun
        end = _AT_THE_END if self.succeeded else ()
        return not record.getMessage().startswith((*_TEXTS, *end))

    def _follow(self, event: LogEvent | None, record: logging.LogRecord) -> None:
        if self.progress is None:
            return
        jobs = getattr(record, "jobs", None) or [getattr(record, "job_id", None)]
        with self._harmless():
            for recipe in [self._recipes[job] for job in jobs if job in self._recipes]:
                if event == LogEvent.JOB_STARTED:
                    self.progress.began(recipe)
                elif event == LogEvent.JOB_FINISHED:
                    self.progress.ended(recipe)


def _point_to_log(logs: list[str]) -> None:
    """Say where the log is and how it ends: a killed job cannot, and Snakemake keeps quiet."""
    for log in (Path(str(name)) for name in logs):
        lines = log.read_text(encoding="utf-8", errors="replace") if log.is_file() else ""
        if _SHOWN in lines:
            continue
        last = [line for line in lines.splitlines() if line.strip()][-_TAIL:]
        end = "".join(f"\n  {line}" for line in last)
        print(f"slider: the job's log is {log}{end}", file=sys.stderr)
