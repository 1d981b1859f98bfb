"""What the head of a run on a cluster tells Snakemake."""

import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from pipeline.cluster import lead

SNAKEFILE = f"""
import sys, threading
sys.path.insert(0, {str(Path(__file__).parents[2])!r})
from pipeline.cluster import lead
rule all:
    input: expand("{{i}}", i=range(10))
rule one:
    output: "{{i}}"
    shell: "touch {{output}}"
onstart:
    lead(workflow, "plan.json")
onsuccess:
    print("threads", threading.active_count())
"""


@pytest.mark.parametrize("given", [["hydra=experiment=test"], [], None])
def test_the_head_names_its_plan_to_its_jobs(monkeypatch, given):
    monkeypatch.setattr(signal, "signal", lambda *_: None)
    workflow = SimpleNamespace(
        local_exec=False,
        config_settings=SimpleNamespace(config_args=given),
        remote_execution_settings=SimpleNamespace(seconds_between_status_checks=20),
        scheduler=SimpleNamespace(_executor=type("Executor", (), {})()),
    )
    lead(workflow, Path("artefacts/plans/a.json"))
    named = [*(given or []), "plan=artefacts/plans/a.json"]
    assert workflow.config_settings.config_args == named


def test_ended_jobs_leave_no_threads_behind(tmp_path):
    (tmp_path / "Snakefile").write_text(SNAKEFILE)
    command = [sys.executable, "-m", "snakemake", "-j2", "--scheduler", "greedy"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    (threads,) = (line.split()[1] for line in done.stdout.splitlines() if "threads " in line)
    assert int(threads) <= 4  # this one and those of the two slots
