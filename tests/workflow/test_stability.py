"""Stability in the real pipeline: beside the way to Table 1."""

import csv

import pytest

from tests.workflow.workspace import finished as finished_pipeline

pytestmark = pytest.mark.workflow

TARGET = "reports/stability.csv"


def test_a_policy_on_top_of_the_controller_goes_through_the_ablation(session_folder, tmp_path):
    workspace = finished_pipeline(session_folder).copy(tmp_path / "copy")
    hydra = "ablation.run=[residual_hzd] ablation.seeds=[1]"
    found = workspace.computed(hydra, target="reports/ablation.csv")
    made = ["ablation", "evaluation", "evaluation", "foot_placement", "stability_gaits", "walking"]
    assert found == made
    rows = list(
        csv.DictReader((workspace.folder / "reports/ablation.csv").read_text().splitlines())
    )
    assert [(row["variant"], row["success_rate"]) for row in rows] == 2 * [("residual_hzd", "1")]


def test_stability_is_a_target_of_its_own(session_folder, tmp_path):
    first = finished_pipeline(session_folder)
    assert not [stage for stage in first.stages() if "stability" in stage]
    workspace = first.copy(tmp_path / "copy")
    assert workspace.computed("", target=TARGET) == ["return_maps", "stability", "stability_gaits"]
    (manifest,) = workspace.manifests("stability_gaits")
    assert set(manifest["inputs"]) == {"library"}, "it waits for no training"
    rows = list(csv.DictReader((workspace.folder / TARGET).read_text().splitlines()))
    assert [float(row["vx"]) for row in rows] == [0.2, 0.4]
    assert all(float(row["closed_spectral_radius"]) < 1 for row in rows)
    assert workspace.computed("hzd.basin.points=3", target=TARGET) == []
