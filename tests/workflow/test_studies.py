"""Studies in the real pipeline: what a finished run has is computed once."""

import pytest

from tests.workflow.workspace import finished

pytestmark = pytest.mark.workflow


def test_a_study_computes_what_is_new_and_a_file_is_a_study(session_folder, tmp_path):
    workspace = finished(session_folder).copy(tmp_path / "copy")
    reports = workspace.folder / "reports"
    target = "reports/sensitivity.csv"
    assert workspace.computed(target=target) == sorted(
        [*["gait"] * 8, *["evaluation"] * 6, "study"]
    )
    assert len((reports / "sensitivity_runs.csv").read_text().splitlines()) == 1 + 2 * (1 + 4)
    assert (reports / "figures/sensitivity.svg").is_file()
    assert workspace.computed(target=target) == []
    starts = "reports/gait_starts.csv"
    assert workspace.computed(target=starts) == ["gait_start", "gait_start", "study"]
    more = workspace.computed("study.gait_starts.starts.count=3", target=starts)
    assert more == ["gait_start", "study"]
    text = "defaults: [gait_starts, _self_]\nstarts: {count: 3}\nspeeds: [0.4]\n"
    (workspace.folder / "conf/study/mine.yaml").write_text(text)
    spread = "study.mine.starts.spread.joints=0.05"
    assert workspace.computed(spread, target="reports/mine.csv") == ["study"]
