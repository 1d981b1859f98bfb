"""The benchmark of the controllers measures what it says."""

import re

import pytest

from slider.bench.control import measure
from slider.cli import main
from slider.control import qp
from tests.control.hzd.test_controller import gaits
from tests.env.synthetic import config


@pytest.mark.parametrize("name", ["mpc_wbc_tuned", "hzd"])
def test_parts_are_of_the_whole(name):
    solve = qp.solve
    cost = measure(config(), name, gaits() if name == "hzd" else None, 8, 0.2, 0.6)
    parts = cost.parts
    assert {"model", "assembly", "solution"} <= parts.keys()
    assert ("footsteps" in parts) == (name == "mpc_wbc_tuned")
    assert min(parts.values()) > 0
    assert sum(parts.values()) < cost.whole
    assert cost.qps > 0
    assert cost.physics > 0
    assert qp.solve is solve


def test_it_prints_a_row_per_command(capsys):
    arguments = ["--robots", "4", "--seconds", "0.04", "--vx", "0.2", "1.0"]
    assert main(["benchmark-control", "--controllers", "mpc_wbc_literal", *arguments]) == 0
    shown = capsys.readouterr().out
    assert re.findall(r"^mpc_wbc_literal +([\d.]+) +[\d.]+ ", shown, re.MULTILINE) == ["0.2", "1.0"]


def test_bad_input_is_one_line(capsys, tmp_path):
    assert main(["benchmark-control", "--controllers", "mpc"]) == 1
    assert "expected some of hzd, mpc_wbc_literal" in capsys.readouterr().err
    assert main(["benchmark-control", "--robots", "0"]) == 1
    assert "expected robots and a time, found 0 for 2 s" in capsys.readouterr().err
    nowhere = ["--artefacts", str(tmp_path)]
    assert main(["benchmark-control", "--controllers", "hzd", *nowhere]) == 1
    assert "snakemake -j2 reports/gait_walks.csv" in capsys.readouterr().err
