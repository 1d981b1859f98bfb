"""Snakemake's log records on the terminal: errors pass, routine messages are dropped."""

import logging
import re
import signal
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any

from snakemake.logging import logger
from snakemake_interface_logger_plugins.common import LogEvent

from pipeline.private import needed_jobs
from pipeline.progress import Progress
from slider.artefacts.plan import Plan
from slider.artefacts.store import Store
from slider.tracking import Tracking

_EVENTS = (LogEvent.JOB_STARTED, LogEvent.JOB_FINISHED, LogEvent.PROGRESS)
_OF_A_RUN = (LogEvent.RUN_INFO, LogEvent.RESOURCES_INFO)  # the output of a dry run
_TEXTS = (
    *("Select jobs to execute...", "Execute ", "Assuming unrestricted", "Building DAG"),
    *("Using shell", "Elapsed time"),
)
# Snakemake's message about a failed job of this pipeline: the full command, and how it ended.
_ENDED = re.compile(
    r"Command '.* run --plan \S+ (?P<recipe>[0-9a-f]{64})\b.*' "
    r"(died with <Signals\.(?P<name>\w+)|returned non-zero exit status (?P<status>\d+))",
    re.DOTALL,
)
_BY_STATUS = {str(128 + number): number.name for number in signal.Signals}  # in some shells
_OUT_OF_MEMORY = "SIGKILL, as the system does where memory runs out"


@dataclass
class Console:
    """Filters the records of Snakemake's logger and follows its jobs."""

    workflow: Any
    progress: Progress | None = None
    tracking: Tracking | None = None

    def __post_init__(self) -> None:
        self._recipes: dict[int, str] = {}
        self._labels: dict[str, str] = {}
        logger.addFilter(self._is_news)

    def open(self, plan: Plan, store: Store, tracking: Tracking | None) -> None:
        """Start to display and track the jobs that Snakemake is about to run."""
        with self._guarded():
            self.tracking = tracking
            self._recipes = needed_jobs(self.workflow)
            self._labels = {recipe: plan.jobs[recipe].label for recipe in self._recipes.values()}
            cores = self.workflow.resource_settings.cores or 1
            if self._recipes:
                self.progress = Progress(plan, store, self._recipes.values(), cores)
                self.progress.open()

    def close(self) -> None:
        """Stop the lines about running jobs."""
        with self._guarded():
            if self.progress is not None:
                self.progress.close()

    @contextmanager
    def _guarded(self) -> Iterator[None]:
        """Keep errors of the display from ending a run: after an error the display is off."""
        try:
            yield
        except Exception:
            with suppress(OSError):  # the terminal may be closed
                traceback.print_exc()
            if self.progress is not None:
                self.progress.close()
            self.progress = None

    def _is_news(self, record: logging.LogRecord) -> bool:
        event = getattr(record, "event", None)
        with self._guarded():
            names = ("jobs", "job_id", "jobid")  # of jobs that started, ended, failed
            jobs = next((vars(record)[name] for name in names if name in vars(record)), [])
            jobs = jobs if isinstance(jobs, list) else [jobs]
            for recipe in [self._recipes[job] for job in jobs if job in self._recipes]:
                for follower in filter(None, (self.tracking, self.progress)):
                    if event == LogEvent.JOB_STARTED:
                        follower.began(recipe)
                    elif event in (LogEvent.JOB_FINISHED, LogEvent.JOB_ERROR):
                        follower.ended(recipe, event == LogEvent.JOB_FINISHED)
        if event in _EVENTS:
            return False
        if event in _OF_A_RUN:
            return self.workflow.dryrun
        if event == LogEvent.ERROR and (ended := _ENDED.search(record.getMessage())):
            with self._guarded():
                self._show_end(**ended.groupdict())
            return False
        return not record.getMessage().startswith(_TEXTS)

    def _show_end(self, recipe: str, name: str | None, status: str | None) -> None:
        """Write which signal ended a job; a job that exited on its own has written the reason."""
        if name := name or _BY_STATUS.get(status or ""):
            cause = _OUT_OF_MEMORY if name == signal.SIGKILL.name else name
            kept = "results and checkpoints are kept, the same command continues from there"
            label = self._labels.get(recipe, "the job")
            print(f"slider: {label}: ended by {cause}; {kept}", file=sys.stderr)
