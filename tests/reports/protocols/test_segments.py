"""The report of changing commands from segments whose answers are known."""

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from slider.config.convert import to_dict
from slider.core.job import Job
from slider.evaluation import segments
from slider.evaluation.results import AXES, MEASURES, Evaluation
from slider.reports.protocols import segments as report
from tests.evaluation.test_results import random_robots
from tests.evaluation.test_segments import case, protocol, recording


def write_evaluation(folder: Path, fall: bool = False) -> Path:
    folder.mkdir(parents=True)
    rollout = recording()
    if fall:
        rollout = replace(rollout, alive=np.zeros_like(rollout.alive))
    found = tuple(segments.measure(rollout, protocol(), case()))
    traces = segments.traces(rollout, protocol())
    evaluation = Evaluation("policy", None, random_robots(), case="tour", segments=found)
    replace(evaluation, traces=traces).save(folder)
    return folder


def run(folder: Path, fall: bool = False):
    out = folder / "out"
    inputs = [write_evaluation(folder / "a", fall)]
    out.mkdir()
    section = {
        "name": "joystick",
        "evaluation": to_dict(protocol()),
        "labels": {"policy": "policy (ours)"},
    }
    summary = report.run(section, {"evaluations": inputs}, out, Job(folder))
    rows = list(csv.DictReader((out / "joystick.csv").read_text().splitlines()))
    return summary, rows, out


def test_one_row_per_segment_with_means_of_those_that_are_up(tmp_path):
    summary, rows, out = run(tmp_path)
    names = {path.name for path in out.iterdir()}
    assert names == {f"joystick.{suffix}" for suffix in ("csv", "md", "svg", "png")}
    assert [row["segment"] for row in rows] == ["stand", "turn", "side"]
    turn = rows[1]
    commanded = [turn[f"{axis}_command"] for axis in AXES]
    assert commanded == ["0.4", "0", "0.3"]
    assert (turn["success_rate"], rows[0]["success_rate"]) == ("0.75", "1")
    assert float(turn["vx_error"]) == pytest.approx(0.5 / 3, rel=1e-5)
    assert float(turn["yaw_rate_error"]) == pytest.approx(0.4 / 3, rel=1e-5)
    assert summary == {"rows": 3, "success_rate": {"policy": 0.75}}
    assert "| 1 | turn | 0.4, 0, 0.3 | 75 | 0.167 |" in (out / "joystick.md").read_text()


def test_where_all_fall_there_are_no_errors(tmp_path):
    _, rows, out = run(tmp_path, fall=True)
    assert {row["success_rate"] for row in rows} == {"0"}
    assert {row[name] for row in rows for name in MEASURES} == {""}
    assert (out / "joystick.png").stat().st_size > 0


def test_same_input_same_bytes(tmp_path):
    _, _, one = run(tmp_path / "one")
    _, _, other = run(tmp_path / "other")
    for path in one.iterdir():
        assert path.read_bytes() == (other / path.name).read_bytes(), path.name
