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
    yield Console(SimpleNamespace(dryrun=False))
    logger.filters[:] = before


def passes(text: str = "", **facts) -> bool:
    record = logging.LogRecord("snakemake", logging.INFO, "", 0, text, None, None)
    record.__dict__.update(facts)
    return bool(logger.filter(record))


def test_chatter_is_dropped_and_errors_stay(console):
    assert not passes("Building DAG of jobs...")
    assert not passes("Job stats: ...", event=LogEvent.RUN_INFO)
    assert passes("Error in rule walking:", event=LogEvent.JOB_ERROR)
    assert passes("Exiting because a job execution failed.")
    assert passes("Complete log(s): x.log")


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ("died with <Signals.SIGKILL: 9>.", "ended by SIGKILL, as the system does where memory"),
        ("returned non-zero exit status 137.", "ended by SIGKILL, as"),
        ("died with <Signals.SIGSEGV: 11>.", "ended by SIGSEGV; "),
        ("returned non-zero exit status 1.", ""),
    ],
)
def test_a_failed_job_is_one_line_without_its_command(console, capsys, how, said):
    """One that ended by itself has written why."""
    recipe = "ab" * 32
    console._labels = {recipe: "gait 0.4"}
    command = f"Command 'set -e; python -I x.py run --plan a/b.json {recipe} --threads 2' {how}"
    text = f"RuleException:\nCalledProcessError in file stages.smk, line 33:\n{command}"
    assert not passes(text, event=LogEvent.ERROR)
    error = capsys.readouterr().err
    assert error.startswith(f"slider: gait 0.4: {said}") if said else error == ""
    assert passes(text.replace(" run ", " publish "), event=LogEvent.ERROR)


def test_events_of_jobs_are_followed_until_a_line_cannot_be_written(console, capsys):
    """Such an error ends no run."""
    seen = []

    def ended(recipe: str, succeeded: bool) -> None:
        assert succeeded
        seen.append(("ended", recipe))
        raise OSError("no terminal")

    console.progress = SimpleNamespace(
        began=lambda recipe: seen.append(("began", recipe)),
        ended=ended,
        close=lambda: seen.append(("closed",)),
    )
    console._recipes = {3: "a", 4: "b"}
    assert not passes(event=LogEvent.JOB_STARTED, jobs=[3, 4, 9])
    for number in (9, 4, 3):  # the first one is a copy to reports/
        assert not passes(event=LogEvent.JOB_FINISHED, job_id=number)
    assert seen == [("began", "a"), ("began", "b"), ("ended", "b"), ("closed",)]
    assert console.progress is None
    assert "no terminal" in capsys.readouterr().err
