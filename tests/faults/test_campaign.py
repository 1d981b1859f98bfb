"""The campaign in short, and that it would notice; ``make faults`` runs it in full."""

import os
import signal
import subprocess
import sys
import time

import pytest

from tests.workflow.workspace import QUIET, REPOSITORY, TABLE, copy_repository, with_dummies

SHORT = 19
MOMENTS = 20


def campaign(*arguments: str):
    # A process without threads: each trial is a fork of it.
    command = [sys.executable, *arguments]
    return subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True, check=False)


def test_each_trial_ends_with_the_true_table_or_one_line():
    done = campaign("-m", "tests.faults.campaign", "--every", str(SHORT))
    assert done.returncode == 0, done.stderr
    for kind in ("killed", "disk full", "a flipped bit", "a lost file"):
        assert kind in done.stdout


@pytest.mark.faults
def test_all_trials():
    done = campaign("-m", "tests.faults.campaign")
    print(done.stdout)
    assert done.returncode == 0, done.stderr


@pytest.mark.faults
def test_a_run_that_is_killed_at_any_moment_goes_on(tmp_path):
    whole = with_dummies(copy_repository(tmp_path / "whole"))
    start = time.monotonic()
    whole.computed()
    duration = time.monotonic() - start
    for moment in range(MOMENTS):
        run = with_dummies(copy_repository(tmp_path / str(moment)))
        process = run.start(TABLE, hydra=QUIET)
        time.sleep(duration * (moment + 0.5) / MOMENTS)
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        run.snakemake("--unlock", hydra=QUIET)
        run.computed()
        assert run.table.read_text() == whole.table.read_text()
        assert run.slider("store", "verify").returncode == 0
