"""What of Snakemake's records reaches the terminal, and what follows the jobs."""

import logging
from types import SimpleNamespace

import pytest
from snakemake.logging import logger
from snakemake_interface_logger_plugins.common import LogEvent

from pipeline.console import Console


@pytest.fixture
def console():
    before = list(logger.filters)
    yield Console(SimpleNamespace(dryrun=False, local_exec=True))
    logger.filters[:] = before


def passes(text: str = "", **facts) -> bool:
    record = logging.LogRecord("snakemake", logging.INFO, "", 0, text, None, None)
    record.__dict__.update(facts)
    return bool(logger.filter(record))


def test_chatter_is_dropped_and_errors_stay(console):
    assert not passes("Building DAG of jobs...")
    assert not passes("Job stats: ...", event=LogEvent.RUN_INFO)
    assert passes("Error in rule walking:", event=LogEvent.JOB_ERROR, log=[])
    assert passes("Exiting because a job execution failed.")
    assert passes("Complete log(s): x.log")
    console.close(succeeded=True)
    assert not passes("Complete log(s): x.log")


def test_events_of_jobs_with_a_recipe_are_followed(console):
    seen = []
    console.progress = SimpleNamespace(
        began=lambda recipe: seen.append(("began", recipe)),
        ended=lambda recipe: seen.append(("ended", recipe)),
    )
    console._recipes = {3: "a", 4: "b"}
    assert not passes(event=LogEvent.JOB_STARTED, jobs=[3, 4, 9])
    assert not passes(event=LogEvent.JOB_FINISHED, job_id=4)
    assert not passes(event=LogEvent.JOB_FINISHED, job_id=9)  # a copy to reports/
    assert seen == [("began", "a"), ("began", "b"), ("ended", "b")]


def test_a_line_that_cannot_be_written_ends_no_run(console, capsys):
    def fail(recipe: str) -> None:
        raise OSError("no terminal")

    hushed: list[bool] = []
    console.progress = SimpleNamespace(ended=fail, close=lambda: hushed.append(True))
    console._recipes = {3: "a"}
    assert not passes(event=LogEvent.JOB_FINISHED, job_id=3)
    assert console.progress is None
    assert hushed
    assert "no terminal" in capsys.readouterr().err
