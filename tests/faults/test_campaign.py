"""The campaign in short, and that it would notice; ``make faults`` runs it in full."""

import subprocess
import sys

import pytest

from tests.faults.campaign import broken, is_one_line
from tests.faults.chain import Chain, chain
from tests.faults.operations import no_file_beyond
from tests.workflow.workspace import REPOSITORY

SHORT = 19


@pytest.mark.parametrize("every", [SHORT, pytest.param(1, marks=pytest.mark.faults)])
def test_each_trial_ends_with_the_true_table_or_one_line(every):
    # In a process without threads: each trial is a fork of it.
    command = [sys.executable, "-m", "tests.faults.campaign", str(every)]
    done = subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True, check=False)
    print(done.stdout)
    assert done.returncode == 0, done.stderr
    for kind in ("killed", "disk full", "a passing fault", "a flipped bit", "a lost file"):
        assert kind in done.stdout


def test_what_a_log_on_a_full_disk_does_not_take_is_not_said_twice(tmp_path):
    with chain(tmp_path) as whole:
        act = broken("gait 0.2", no_file_beyond, 1)
        assert is_one_line(act(Chain(tmp_path / "fresh", whole.plan)))
