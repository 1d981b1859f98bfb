"""Fewer lines while the pipeline runs: every job says itself, in one line, that it is done."""

import logging
import sys
from pathlib import Path

from snakemake.logging import logger
from snakemake_interface_logger_plugins.common import LogEvent

_EVENTS = (LogEvent.JOB_FINISHED, LogEvent.PROGRESS)
_TEXTS = ("Select jobs to execute...", "Execute ")
_TAIL = 5  # lines of the log of a job that could not speak for itself
_SHOWN = "Traceback (most recent call last)"  # such a job has shown the end of its log itself


def calm() -> None:
    """Drop the four lines that Snakemake's scheduler writes per job; errors stay."""
    logger.addFilter(_is_news)


def _is_news(record: logging.LogRecord) -> bool:
    event = getattr(record, "event", None)
    if event == LogEvent.JOB_ERROR:
        _point_to_log(getattr(record, "log", None) or [])
    if event in _EVENTS:
        return False
    return not record.getMessage().startswith(_TEXTS)


def _point_to_log(logs: list[str]) -> None:
    """Say where the log is and how it ends: a killed job cannot, and Snakemake keeps quiet."""
    for log in (Path(str(name)) for name in logs):
        lines = log.read_text(encoding="utf-8", errors="replace") if log.is_file() else ""
        if _SHOWN in lines:
            continue
        last = [line for line in lines.splitlines() if line.strip()][-_TAIL:]
        end = "".join(f"\n  {line}" for line in last)
        print(f"slider: the job's log is {log}{end}", file=sys.stderr)
