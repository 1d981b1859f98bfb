"""The benchmark of the controllers measures what it claims."""

import re

import pytest

from slider.bench.controllers import measure
from slider.cli import main
from slider.control.whole_body.model import NominalModel
from tests.control.hzd.test_controller import gaits
from tests.env.synthetic import config


@pytest.mark.parametrize("name", ["mpc_wbc_tuned", "hzd"])
def test_parts_add_up_to_less_than_the_rollout(name):
    evaluate = NominalModel.evaluate
    cost = measure(config(), name, gaits() if name == "hzd" else None, 8, 0.2, 0.6)
    whole = cost.pop("whole")
    assert {"model", "assembly", "solution", "physics"} <= cost.keys()
    assert ("footsteps" in cost) == (name == "mpc_wbc_tuned")
    assert min(cost.values()) > 0
    assert sum(cost.values()) < whole
    assert NominalModel.evaluate is evaluate, "methods come back"


def test_it_prints_a_row_per_speed(capsys):
    arguments = ["--robots", "4", "--seconds", "0.04", "--vx", "0.2", "1.0"]
    assert main(["benchmark-control", "--controllers", "mpc_wbc_literal", *arguments]) == 0
    shown = capsys.readouterr().out
    assert re.findall(r"^mpc_wbc_literal +([\d.]+) +[\d.]+ ", shown, re.MULTILINE) == ["0.2", "1.0"]


def test_bad_input_is_one_line(capsys, tmp_path):
    for arguments, message in (
        (["--controllers", "mpc"], "expected some of hzd, mpc_wbc_literal"),
        (["--robots", "0"], "expected robots and a time, found 0 for 2 s"),
        (["--controllers", "hzd", "--artefacts", str(tmp_path)], "reports/gait_walks.csv"),
    ):
        assert main(["benchmark-control", *arguments]) == 1
        assert message in capsys.readouterr().err
