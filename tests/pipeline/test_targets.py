"""Every target has its own name and its own files, protocols included."""

import re
from pathlib import Path

import pytest

from pipeline.targets import RULES, all_targets, report_files
from slider.config.compose import compose
from slider.core.errors import UserError

CONF = Path(__file__).parents[2] / "conf"
SMALL = ["experiment=test", "report.sections=[table1]"]
TAKEN = "table1 library report untuned speeds policy all videos seeds gait_quality ablation_curves"


def targets(*overrides: str):
    given = [*SMALL, *overrides]
    return all_targets(compose(given, CONF), given, CONF)


@pytest.mark.parametrize("name", TAKEN.split())
def test_a_protocol_takes_no_name_of_another(name):
    message = f"protocols.{name}: expected a name that no target, stage, rule or report has, found "
    with pytest.raises(UserError, match=f"^{message}{name}$"):
        targets(f"+protocols.{name}=${{protocols.sweep}}")


def test_every_target_but_protocols_is_taken():
    config = compose(SMALL, CONF)
    for name in {*targets(), *config.study} - {*config.protocols}:
        with pytest.raises(UserError, match=rf"^protocols\.{name}: expected"):
            targets(f"+protocols.{name}=${{protocols.sweep}}")


@pytest.mark.parametrize("name", ["table1", "sweep", "study", "figures", "gait_quality"])
def test_a_study_takes_no_name_of_another(name):
    with pytest.raises(UserError, match=rf"{name}: expected a name that no target, stage, rule"):
        targets(f"+study.{name}=${{study.gait_starts}}")


def test_rules_with_a_name_of_their_own_are_known():
    """A rule that a protocol could be taken for is among ``RULES``, or the name of a target."""
    root = CONF.parent
    texts = [p.read_text() for p in (root / "Snakefile", *(root / "pipeline/rules").glob("*.smk"))]
    rules = {name for text in texts for name in re.findall(r"^rule (\w+):", text, re.M)}
    assert {"all", "policy"} <= rules <= {*RULES, *report_files(compose(SMALL, CONF))}


def test_another_protocol_is_a_target_with_files_of_its_own():
    given = [*SMALL, "+protocols.mine=${protocols.sweep}"]
    assert "mine" in all_targets(compose(given, CONF), given, CONF)
    files = [file for files in report_files(compose(given, CONF)).values() for file in files]
    assert {"reports/mine.csv", "reports/ablation_curves.csv"} <= {*files}
    assert len(files) == len(set(files))


def test_a_bound_is_of_something_that_is_verified():
    with pytest.raises(UserError, match=r"^verification\.bounds: expected one of dynamics_torque"):
        targets("+verification.bounds.zzz=1")
