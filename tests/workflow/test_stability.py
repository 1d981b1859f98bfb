"""Stability in the real pipeline: beside the way to Table 1."""

import csv

import pytest

from tests.workflow.workspace import Workspace
from tests.workflow.workspace import finished as finished_pipeline

pytestmark = pytest.mark.workflow

TARGET = "reports/stability.csv"


@pytest.fixture(scope="module")
def workspace(session_folder, tmp_path_factory) -> Workspace:
    """A finished pipeline and its stability."""
    first = finished_pipeline(session_folder)
    assert not [stage for stage in first.stages() if "stability" in stage]
    workspace = first.copy(tmp_path_factory.mktemp("stability") / "copy")
    assert workspace.computed("", target=TARGET) == ["return_maps", "stability", "stability_gaits"]
    return workspace


def test_stability_is_a_target_of_its_own(workspace):
    (manifest,) = workspace.manifests("stability_gaits")
    assert set(manifest["inputs"]) == {"library"}, "it waits for no training"
    rows = list(csv.DictReader((workspace.folder / TARGET).read_text().splitlines()))
    assert [float(row["vx"]) for row in rows] == [0.2, 0.4]
    assert all(float(row["closed_spectral_radius"]) < 1 for row in rows)
    assert workspace.computed("hzd.basin.points=3", target=TARGET) == []
