"""The benchmark of growth measures what it says."""

import re
from argparse import Namespace
from pathlib import Path

import pytest

from slider.artefacts.store import Store
from slider.bench import growth
from slider.cli import main
from slider.commands.results import growth as growth_tables

ROOT = Path(__file__).parents[2]


@pytest.fixture(autouse=True)
def repository(monkeypatch):
    monkeypatch.chdir(ROOT)


def test_points_are_printed_written_and_shown(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(growth, "_COUNTS", (3, 12))
    out = tmp_path / "growth.csv"
    assert main(["benchmark-growth", "--curves", "objects", "--out", str(out)]) == 0
    printed = capsys.readouterr().out
    assert re.search(r"^ +12 objects +verify \[s\] +[\d.]+$", printed, re.MULTILINE)
    table = growth_tables(out).splitlines()
    assert table[0] == "| objects | 3 | 12 |"
    assert re.fullmatch(r"\| gc of all \[s\] \| [\d.]+ \| [\d.]+ \|", table[-1])


def test_the_store_that_is_measured_is_a_store(tmp_path):
    store = Store(tmp_path)
    growth._fill(store, 7)
    assert len(store.manifests()) == 7
    assert all(store.usable(path) for path in store.manifests())


def test_a_larger_problem_takes_longer(monkeypatch):
    monkeypatch.setattr(growth, "_NODES", (5, 51))
    monkeypatch.setattr("slider.bench.gaits.VELOCITIES", ((0.3, 0.0),))
    points = {
        (count, name): value for count, name, value in growth._nodes(Namespace(conf=Path("conf")))
    }
    assert points[51, "iteration [ms]"] > points[5, "iteration [ms]"] > 0


def test_bad_input_is_one_line(capsys, tmp_path, monkeypatch):
    assert main(["benchmark-growth", "--threads", "0"]) == 1
    assert "--threads: expected at least 1, found 0" in capsys.readouterr().err
    monkeypatch.chdir(tmp_path)
    assert main(["benchmark-growth"]) == 1
    assert "expected Snakefile in this folder, found none" in capsys.readouterr().err
