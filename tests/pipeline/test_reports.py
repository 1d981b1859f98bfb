"""When a report is copied out of the store again."""

from pathlib import Path

import pytest

from pipeline.targets import marker_path, refresh_marker
from slider.artefacts.manifest import Manifest
from slider.artefacts.plan import JobSpec, build_plan
from slider.artefacts.recipe import Code
from slider.artefacts.store import Store


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path / "artefacts")


def test_a_marker_changes_whenever_the_report_is_not_the_plan_s(store, tmp_path):
    job = JobSpec("table1", "table 1", Code("a:run", "", {}), {})
    plan, report = build_plan({"table1": job}), tmp_path / "table1.csv"
    with store.temporary("test") as out:
        (out / "table1.csv").write_text("a\n")
        result = store.publish(out, {})
    store.write_manifest(Manifest("table1", job.recipe, {}, result))
    marker = marker_path(store, "table1")

    def refreshed() -> list[str]:
        refresh_marker(store, plan, "table1", [report])
        return marker.read_text().split()

    assert refreshed() == [job.recipe]
    report.write_text("a\n")
    assert refreshed() == [job.recipe]
    report.write_text("edited\n")
    assert refreshed()[0] == job.recipe
    assert len(refreshed()) == 2
    report.write_text("a\n")
    marker.write_bytes(b"\xff\xfe")
    assert refreshed() == [job.recipe]
