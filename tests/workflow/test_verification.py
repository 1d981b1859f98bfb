"""The checks of gaits in the real pipeline: beside the way to Table 1, and ended by a bound."""

import json
from typing import Any

import pytest

from tests.workflow.workspace import QUIET, Workspace
from tests.workflow.workspace import finished as finished_pipeline

pytestmark = pytest.mark.workflow

TARGET = "reports/verification.csv"
SHORT = "verification.replay.steps=2 verification.points=21"
STRICT = f"{SHORT} verification.bounds.return_map=2.0"


def verdict(workspace: Workspace) -> dict[str, Any]:
    return json.loads((workspace.folder / "reports" / "verification.json").read_text())


def test_verification_is_a_target_of_its_own(session_folder, tmp_path):
    first = finished_pipeline(session_folder)
    assert not [stage for stage in first.stages() if "verification" in stage]
    workspace = first.copy(tmp_path / "copy")
    found = workspace.computed(SHORT, target=TARGET)
    assert found == ["verification", "verification_gaits"]
    (manifest,) = workspace.manifests("verification_gaits")
    assert set(manifest["inputs"]) == {"library"}, "it waits for no training"
    assert verdict(workspace)["passed"]
    assert verdict(workspace)["gaits"] == 2

    hydra = f"{STRICT} {QUIET}"
    failing = workspace.snakemake(TARGET, hydra=f"{hydra} verification.on_failure=error")
    assert failing.returncode == 1
    assert "gait (0.2, 0) m/s, return_map: expected ≤ 2 -" in failing.stderr
    assert len(workspace.manifests("verification_gaits")) == 1  # only the verdict was redone

    assert workspace.computed(STRICT, target=TARGET) == ["verification"]
    assert not verdict(workspace)["passed"]
