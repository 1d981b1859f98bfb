"""The report of the sweep from records whose answers are known."""

import csv

import numpy as np
import pytest

from slider.config.convert import to_dict
from slider.core.job import Job
from slider.reports.protocols import speeds
from tests.env.synthetic import config
from tests.evaluation.test_results import make_robots, write_evaluation

WALKS = make_robots([[1, 1], [1, 1]], [[0.5, 0.25], [0.125, 1.0]])
FALLS = make_robots([[0, 0], [0, 0]], [[1, 1], [1, 1]])


def section() -> dict:
    protocol = to_dict(config("experiment=test").protocols["sweep"])
    return {"name": "sweep", "evaluation": protocol, "labels": {"policy": "policy (ours)"}}


def write(tmp_path, out):
    inputs = [
        write_evaluation(tmp_path / out / "a", 0.2, WALKS),
        write_evaluation(tmp_path / out / "b", 3.0, FALLS),
    ]
    folder = tmp_path / out / "out"
    folder.mkdir()
    return speeds.run(section(), {"evaluations": inputs}, folder, Job(tmp_path)), folder


def folders(tmp_path, out):
    """Of the evaluations."""
    return [tmp_path / out / "a", tmp_path / out / "b"]


def test_the_stage(tmp_path):
    summary, out = write(tmp_path, "one")
    assert {path.name for path in out.iterdir()} == {
        f"sweep.{x}" for x in ("csv", "md", "svg", "png")
    }
    rows = list(csv.DictReader((out / "sweep.csv").read_text().splitlines()))
    assert [row["command_velocity"] for row in rows] == ["0.2", "3"]
    assert [row["success_rate"] for row in rows] == ["1", "0"]
    velocity = np.array([1.5, 1.25, 1.125, 2.0])  # errors + 1
    assert float(rows[0]["mean_velocity"]) == pytest.approx(velocity.mean(), rel=1e-5)
    assert float(rows[0]["mean_velocity_spread"]) == pytest.approx(velocity.std(), rel=1e-5)
    assert (rows[1]["mean_velocity"], rows[1]["mse_steady"]) == ("", "inf")
    assert summary == {"rows": 2, "highest_tracked": {"policy": None}}
    assert "| policy (ours) | none |" in (out / "sweep.md").read_text()


def test_same_input_same_bytes(tmp_path):
    _, one = write(tmp_path, "one")
    _, other = write(tmp_path, "other")
    for path in one.iterdir():
        assert path.read_bytes() == (other / path.name).read_bytes(), path.name


def test_the_highest_tracked_speed():
    shares = {0.2: 1.0, 2.2: 0.9, 3.0: 0.89}
    rows = [
        {"controller": "policy", "command_velocity": v, "tracking_rate": share}
        for v, share in shares.items()
    ] + [{"controller": "other", "command_velocity": 1.0, "tracking_rate": 0.0}]
    assert speeds.highest_tracked(rows) == {"policy": 2.2, "other": None}
