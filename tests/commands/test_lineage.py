"""The status of ``slider lineage diff`` where there is no answer; others are in the workflow."""

import signal
import subprocess

from slider.cli import main


def test_a_plan_that_is_killed_is_no_difference(monkeypatch, capsys):
    killed = subprocess.CompletedProcess([], -signal.SIGKILL, stderr="")
    monkeypatch.setattr(subprocess, "run", lambda *arguments, **more: killed)
    assert main(["lineage", "diff", "train.seed=1", "train.seed=2"]) == 2
    assert capsys.readouterr().err == "slider: expected a plan, found none: status -9\n"
