"""Every target has its own name and files; when these are copied out of the store again."""

import re

import pytest

from pipeline.targets import RULES, all_targets, refresh_marker, report_files
from slider.artefacts.plan import JobSpec, build_plan
from slider.artefacts.recipe import Code
from slider.core.errors import UserError
from tests.artefacts.samples import compute
from tests.config.composed import CONF, composed

SMALL = ["experiment=test", "report.sections=[table1]"]


def targets(*overrides: str):
    given = [*SMALL, *overrides]
    return all_targets(composed(*given), given, CONF)


@pytest.mark.parametrize(
    "key", [*(f"protocols.{name}" for name in ("table1", "untuned", "seeds")), "study.figures"]
)
def test_a_protocol_or_study_takes_no_name_of_another(key):
    """Of a target, a stage, a study."""
    other = "${protocols.sweep}" if key.startswith("protocols") else "${study.gait_starts}"
    with pytest.raises(UserError, match=rf"{key}: expected a name that no target, stage or rule"):
        targets(f"+{key}={other}")


def test_rules_with_a_name_of_their_own_are_known():
    """A rule that a protocol could be taken for is among ``RULES``, or the name of a target."""
    root = CONF.parent
    texts = [p.read_text() for p in (root / "Snakefile", *(root / "pipeline/rules").glob("*.smk"))]
    rules = {name for text in texts for name in re.findall(r"^rule (\w+):", text, re.M)}
    assert {"all", "policy"} <= rules <= {*RULES, *report_files(composed(*SMALL))}


def test_another_protocol_is_a_target_with_files_of_its_own():
    given = [*SMALL, "+protocols.mine=${protocols.sweep}"]
    assert "mine" in all_targets(composed(*given), given, CONF)
    files = [file for files in report_files(composed(*given)).values() for file in files]
    assert {"reports/mine.csv", "reports/ablation_curves.csv"} <= {*files}
    assert len(files) == len(set(files))


def test_a_policy_that_is_not_there_stops_the_gauge_alone():
    missing = ["gauge.controllers=[mine]", "+gauge.policies.mine=nowhere"]
    assert "table1" in targets(*missing)
    with pytest.raises(UserError, match=r"policies\.mine: .* found no nowhere/policy\.onnx$"):
        targets(*missing, "report.sections=[gauge]")


def test_a_marker_changes_whenever_the_report_is_not_the_plan_s(store, tmp_path):
    job = JobSpec("table1", "table 1", Code("a:run", "", {}), {})
    plan, report = build_plan({"table1": job}), tmp_path / "table1.csv"
    compute(store, job, table1="a\n")
    marker = store.root / "current" / "table1"

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
