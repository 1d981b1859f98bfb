"""The benchmark of gaits measures what it says."""

from dataclasses import replace

from slider.bench.gaits import measure
from slider.cli import main
from tests.gait.gaits import config


def test_a_measurement_is_of_real_solves():
    found = measure(config().robot, replace(config().gait, nodes=21), [(0.2, 0.0)])
    nodes, gaits, built, median, _, longest, *_, inside = found.split()
    assert (nodes, gaits) == ("21", "1")
    assert float(built) > 0
    assert float(median) == float(longest) > 0, "of one gait"
    assert 0 < float(inside.rstrip("%")) < 100


def test_impossible_nodes_are_one_line(capsys):
    assert main(["benchmark-gaits", "--nodes", "4"]) == 1
    assert "gait.nodes: expected greater than or equal to 5, found 4" in capsys.readouterr().err
