"""Controllers are data: a file in ``conf/control`` is one, under its own name."""

import shutil
from pathlib import Path

import pytest

from pipeline.stages import table1_jobs
from slider.config.compose import compose
from slider.config.convert import to_dict
from slider.core.errors import UserError

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


def test_every_file_but_the_base_is_a_controller():
    assert controllers() == sorted(compose([], CONF).control)


def test_a_file_is_enough_for_table_1(conf):
    add(conf, "higher")
    overrides = ["evaluation.controllers=[policy,higher]", "control.higher.step.width=0.22"]
    config = compose(overrides, conf)
    evaluations = table1_jobs(config)["table1"].inputs["evaluations"]
    higher = [job for job in evaluations if job.section["controller"] == "higher"]
    assert len(higher) == len(config.evaluation.commands)
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
        ("policy", HIGHER, "control.policy: expected another name than policy, zero, random"),
        ("higher", HIGHER.replace("label: higher\n", ""), r"control.\*.label: expected each once"),
        ("higher", HIGHER.replace("higher\n", '""\n'), "control.higher.label: expected a label"),
        ("higher", HIGHER + "  apx: 0.1\n", "control.higher.step.apx"),
    ],
)
def test_a_mistake_in_a_file_is_one_line(conf, name, text, message):
    with pytest.raises(UserError, match=message) as caught:
        compose([], add(conf, name, text))
    assert "\n" not in str(caught.value)


def test_an_unknown_controller_is_answered_by_the_known_ones():
    known = ", ".join(["policy", *controllers()])
    expected = f"evaluation.controllers: expected one of {known}, found higher"
    with pytest.raises(UserError, match=expected):
        compose(["evaluation.controllers=[policy,higher]"], CONF)
