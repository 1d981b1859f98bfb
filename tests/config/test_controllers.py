"""Controllers are data: a file in ``conf/control`` is one, under its own name."""

import shutil
from pathlib import Path

import pytest

from pipeline.stages import table1_jobs
from slider.artefacts.plan import JobSpec
from slider.composition.compose import compose
from slider.config.control import PAPER_LABELS
from slider.config.convert import to_dict
from slider.reports.table1 import paper_rows
from tests.config.composed import CONF, composed, refusal

HIGHER = "defaults:\n  - mpc_wbc_tuned\n  - _self_\n\nlabel: higher\nstep:\n  apex: 0.1\n"


@pytest.fixture
def conf(tmp_path) -> Path:
    return Path(shutil.copytree(CONF, tmp_path / "conf"))


def add(conf: Path, name: str, text: str = HIGHER) -> Path:
    (conf / "control" / f"{name}.yaml").write_text(text)
    return conf


def test_the_labels_of_the_paper_are_those_of_its_rows():
    rows = paper_rows()
    assert dict(zip(rows["controller"], rows["label"], strict=True)) == PAPER_LABELS


def test_a_file_is_enough_for_table_1_and_changes_no_other_recipe(conf):
    def evaluations(*overrides: str) -> list[JobSpec]:
        return list(table1_jobs(compose(overrides, conf))["table1"].inputs["evaluations"])

    before = [job.recipe for job in evaluations()]
    add(conf, "higher")
    assert [job.recipe for job in evaluations()] == before
    found = evaluations("evaluation.controllers=[policy,higher]", "control.higher.step.width=0.22")
    higher = [job for job in found if job.section["controller"] == "higher"]
    assert len(higher) == len(composed().evaluation.speeds)
    assert {job.stage for job in higher} == {"baseline"}
    expected = to_dict(composed().control["mpc_wbc_tuned"])
    expected["step"] |= {"apex": 0.1, "width": 0.22}
    del expected["label"]  # what people call it changes no result
    assert higher[0].section["control"] == expected


@pytest.mark.parametrize(
    ("name", "label", "message"),
    [
        ("policy", "higher", "control.policy: expected another name than policy, zero, random, "),
        ("all", "higher", "all.yaml: expected small letters, digits and _ after a letter, and not"),
        ("high.er", "higher", "high.er.yaml: expected small letters, digits and _ after a letter"),
        ("higher", "MPC + WBC, tuned", "one line that is not the label of higher "),
        ("higher", '"two\\nlines"', "higher.label: expected one line that is"),
        ("Mine", "higher", "control: expected names of small letters"),
    ],
)
def test_a_mistake_in_a_file_is_one_line(conf, name, label, message):
    text = HIGHER.replace("label: higher", f"label: {label}")
    assert message in refusal([], add(conf, name, text))
