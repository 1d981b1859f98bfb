"""Controllers are data: a file in ``conf/control`` is one, under its own name."""

import shutil
from pathlib import Path

import pytest

from pipeline.stages import table1_jobs
from slider.config.compose import compose
from slider.config.control import PAPER_LABELS
from slider.config.convert import to_dict
from slider.core.errors import UserError
from slider.reports.table1 import paper_rows

CONF = Path(__file__).parents[2] / "conf"
HIGHER = "defaults:\n  - mpc_wbc_tuned\n  - _self_\n\nlabel: higher\nstep:\n  apex: 0.1\n"


@pytest.fixture
def conf(tmp_path) -> Path:
    return Path(shutil.copytree(CONF, tmp_path / "conf"))


def add(conf: Path, name: str, text: str = HIGHER) -> Path:
    (conf / "control" / f"{name}.yaml").write_text(text)
    return conf


def controllers() -> list[str]:
    return sorted(path.stem for path in (CONF / "control").glob("*.yaml") if path.stem != "base")


def labelled(label: str, message: str) -> tuple[str, str, str]:
    return "higher", HIGHER.replace("label: higher", f"label: {label}"), message


def test_the_labels_of_the_paper_are_those_of_its_rows():
    assert {row["controller"]: row["label"] for row in paper_rows()} == PAPER_LABELS


def test_every_file_but_the_base_is_a_controller():
    assert controllers() == sorted(compose([], CONF).control)


def test_a_file_is_enough_for_table_1(conf):
    add(conf, "higher")
    overrides = ["evaluation.controllers=[policy,higher]", "control.higher.step.width=0.22"]
    config = compose(overrides, conf)
    evaluations = table1_jobs(config)["table1"].inputs["evaluations"]
    higher = [job for job in evaluations if job.section["controller"] == "higher"]
    assert len(higher) == len(config.evaluation.speeds)
    assert {job.stage for job in higher} == {"baseline"}
    expected = to_dict(config.control["mpc_wbc_tuned"])
    expected["step"] |= {"apex": 0.1, "width": 0.22}
    del expected["label"]  # what people call it changes no result
    assert higher[0].section["control"] == expected


def test_an_experiment_may_change_a_controller(conf):
    text = "# @package _global_\ncontrol:\n  mpc_wbc_tuned:\n    step: {apex: 0.09}\n"
    (conf / "experiment" / "high.yaml").write_text(text)
    controls = compose(["experiment=high"], conf).control
    assert controls["mpc_wbc_tuned"].step.apex == 0.09
    assert controls["mpc_wbc_observer"].step.apex == 0.07


def test_another_file_changes_no_other_recipe(conf):
    def recipes():
        jobs = table1_jobs(compose([], conf))["table1"].inputs["evaluations"]
        return [job.recipe for job in jobs]

    before = recipes()
    assert before == (add(conf, "higher"), recipes())[1]


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("policy", HIGHER, "control.policy: expected another name than policy, zero, random, "),
        ("mpc_wbc", HIGHER, "control.mpc_wbc: expected another name than .*, found mpc_wbc"),
        labelled("MPC + WBC, tuned", "another label than that of higher .*, found MPC"),
        labelled("MPC + WBC (paper)", "another label than that of mpc_wbc .*, found MPC"),
        labelled('"two\\nlines"', r"higher.label: expected one line of text, found 'two\\nlines'"),
        labelled('" "', "higher.label: expected one line of text"),
        ("higher", HIGHER + "  apx: 0.1\n", "control.higher.step.apx"),
    ],
)
def test_a_mistake_in_a_file_is_one_line(conf, name, text, message):
    with pytest.raises(UserError, match=message) as caught:
        compose([], add(conf, name, text))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["all", "Mine", "a-b"])
def test_a_file_has_a_name_that_keys_may_have(conf, name):
    with pytest.raises(UserError, match=rf"control/{name}\.yaml: expected small .*, found {name}$"):
        compose([], add(conf, name))


@pytest.mark.parametrize("chosen", ["mpc_wbc_tuned", "null", ""])
def test_the_group_is_all_controllers(chosen):
    expected = "control: expected all; evaluation.controllers chooses controllers, found "
    with pytest.raises(UserError) as caught:
        compose([f"control={chosen}"], CONF)
    assert str(caught.value).startswith(expected + chosen)
    assert compose(["control=all"], CONF).control == compose([], CONF).control
