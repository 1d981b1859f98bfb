"""Jobs that a signal interrupts; ``make faults`` does it at ten moments of each kind."""

import subprocess
import sys

import pytest

from tests.faults.signals import BUILT, SIGNALS, Jobs
from tests.workflow.workspace import REPOSITORY


def test_a_gait_that_was_interrupted_within_ipopt_has_the_same_bytes(tmp_path):
    """CasADi swallows what a handler of Python raises there, and would try the next guess."""
    jobs = Jobs.laid_out(tmp_path)
    gait = jobs.specs["gait"]
    truth = jobs.run(gait)
    for number in SIGNALS:
        jobs.forget(gait)
        jobs.interrupt(gait, number, 0.2, after=BUILT)
        assert jobs.run(gait) == truth, number.name


def test_gaits_solved_in_another_order_make_the_same_library(tmp_path):
    jobs = Jobs.laid_out(tmp_path)
    (library,) = jobs.specs["training"].inputs["library"]
    truth, gaits = jobs.run(library), library.inputs["gaits"]
    for spec in (library, *gaits):
        jobs.forget(spec)
    for spec in reversed(gaits):
        jobs.run(spec)
    assert jobs.run(library) == truth


@pytest.mark.faults
def test_any_moment_of_any_job():
    command = [sys.executable, "-m", "tests.faults.signals"]
    done = subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True, check=False)
    print(done.stdout)
    assert done.returncode == 0, done.stdout + done.stderr
