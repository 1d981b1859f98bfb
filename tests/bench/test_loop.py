"""The benchmark of the training measures what it claims."""

import re

import pytest

from slider.bench.loop import measure
from slider.cli import main
from tests.library.gaits import write_store
from tests.training.test_trainer import task


@pytest.mark.parametrize("simulator", ["mujoco", "mujoco_warp"])
def test_rates_and_shares_are_of_the_same_run(simulator):
    if simulator == "mujoco_warp":
        pytest.importorskip("mujoco_warp", reason="needs the extra gpu")
    rates, parts = measure(task(robots=8, simulator=simulator), 1, seconds=0.05, rounds=2)
    assert rates.shape == (2, 2)
    assert (rates > 0).all()
    assert sum(parts.values()) == pytest.approx(1.0)
    assert {"physics", "state", "observation", "reward", "policy", "update"} <= parts.keys()
    assert min(parts.values()) > 0


def test_it_runs_with_the_default_configuration(tmp_path, capsys):
    library = write_store(tmp_path, [(0.0, 0.0), (1.0, 0.0), (3.0, 0.0)])
    arguments = ["--envs", "4", "--seconds", "0.01", "--rounds", "1", "--threads", "1"]
    arguments += ["--library", str(library)]
    assert main(["benchmark-training", *arguments]) == 0
    shown = capsys.readouterr().out
    assert re.search(r"^ +4 +[\d.]+ \(", shown, re.MULTILINE)


def test_bad_input_is_one_line(refused, tmp_path):
    for arguments, message in (
        (["--envs", "0"], "slider: --envs: expected "),
        (["--seconds", "nan"], "slider: --seconds: expected "),
        (["--envs", "8", "--artefacts", str(tmp_path)], "snakemake -j2 gait_library"),
    ):
        assert message in refused("benchmark-training", *arguments)
