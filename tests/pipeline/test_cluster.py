"""What the head of a run on a cluster tells Snakemake."""

import signal
from pathlib import Path
from types import SimpleNamespace

import pytest

from pipeline.cluster import lead


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
