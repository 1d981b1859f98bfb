"""The benchmark of gaits measures what it says."""

from dataclasses import replace

from slider.bench.gaits import measure
from slider.cli import main
from tests.gait.gaits import config


def test_a_measurement_is_of_real_solves():
    found = measure(config().robot, replace(config().gait, nodes=21), [(0.2, 0.0)])
    assert found.build > 0
    assert [solve.success for solve in found.solves] == [True]
    inside = sum(found.solves[0].evaluations.values())
    assert 0 < inside < found.solves[0].cpu
    assert found.line().split()[:2] == ["21", "1"]


def test_impossible_nodes_are_one_line(capsys):
    assert main(["benchmark-gaits", "--nodes", "4"]) == 1
    assert "gait.nodes: expected an odd number" in capsys.readouterr().err
