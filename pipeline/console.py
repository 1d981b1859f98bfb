"""Fewer lines while the pipeline runs: every job says itself, in one line, that it is done."""

import logging

from snakemake.logging import logger
from snakemake_interface_logger_plugins.common import LogEvent

_EVENTS = (LogEvent.JOB_FINISHED, LogEvent.PROGRESS)
_TEXTS = ("Select jobs to execute...", "Execute ")


def calm() -> None:
    """Drop the four lines that Snakemake's scheduler writes per job; errors stay."""
    logger.addFilter(_is_news)


def _is_news(record: logging.LogRecord) -> bool:
    if getattr(record, "event", None) in _EVENTS:
        return False
    return not record.getMessage().startswith(_TEXTS)
