"""The checks of gaits in the real pipeline: beside the way to Table 1, and ended by a bound."""

import json

import pytest

from tests.workflow.workspace import copy_repository

pytestmark = pytest.mark.workflow

TARGET = "reports/verification.csv"
SHORT = "tracking.enabled=false verification.replay.steps=2 verification.points=21"
STRICT = f"{SHORT} verification.bounds.return_map=2.0"


def test_verification_is_a_target_of_its_own(tmp_path):
    workspace = copy_repository(tmp_path)
    plan = workspace.snakemake("-n", "reports/table1.csv", hydra=SHORT)
    assert "verification" not in plan.stdout + plan.stderr
    done = workspace.snakemake(TARGET, hydra=SHORT)
    assert done.returncode == 0, done.stderr
    assert not (tmp_path / "artefacts" / "walking").exists()
    summary = json.loads((tmp_path / "reports" / "verification.json").read_text())
    assert summary["passed"]
    assert summary["gaits"] == 2

    failing = workspace.snakemake(TARGET, hydra=f"{STRICT} verification.on_failure=error")
    assert failing.returncode == 1
    assert "gait (0.2, 0) m/s, return_map: expected ≤ 2 -" in failing.stderr
    assert len(workspace.manifests("verification_gaits")) == 1  # only the verdict was redone

    reported = workspace.snakemake(TARGET, hydra=STRICT)
    assert reported.returncode == 0, reported.stderr
    summary = json.loads((tmp_path / "reports" / "verification.json").read_text())
    assert not summary["passed"]
