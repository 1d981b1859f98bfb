"""The report of cases from rollouts whose answers are known."""

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from slider.config.convert import to_dict
from slider.config.evaluation import CaseConfig, EvaluationConfig, ProfileConfig, Segment
from slider.core.job import Job
from slider.env.metrics import tracking
from slider.env.rollout import Recording
from slider.evaluation import segments
from slider.evaluation.results import Evaluation, wilson
from slider.evaluation.segments import commands
from slider.reports.protocols import cases
from tests.env.synthetic import config, make_contacts
from tests.evaluation.test_results import random_robots

PERIOD, SECONDS, COUNT = 0.02, 10.0, 4
STEPS = round(SECONDS / PERIOD)
STOP = CaseConfig(
    "stop from 0.4 m/s", [Segment("walk", 0.0, 0.4, 0.0, 0.0), Segment("stop", 4.0, 0.0)]
)
SIDE = CaseConfig("0.4 m/s leftward", [Segment("walk", 0.0, 0.4, 0.1)])


def protocol() -> EvaluationConfig:
    whole = config("experiment=test").evaluation
    profile = ProfileConfig(0.0, 3.0, 0.8, "cases", [STOP, SIDE])
    return replace(whole, profile=profile, duration=SECONDS, trials=2, robots=2, commands=[])


def recording(case: CaseConfig, alive: np.ndarray) -> Recording:
    """Robot 0 tracks exactly; 1 goes on with 0.05 and 2 with 0.2 m/s after 4 s; 3: 0.02 m/s off."""
    command = np.repeat(commands(case, 0.0, SECONDS, PERIOD)[:, None], COUNT, axis=1)
    velocity = command[:, :, :2].copy()
    late = round(4.0 / PERIOD)
    velocity[late:, 1, 1] += 0.05
    velocity[late:, 2, 0] += 0.2
    velocity[:, 3] += 0.02
    velocity[::2, 1:] += 0.5  # sway that a mean over half a second does not show
    velocity[1::2, 1:] -= 0.5
    zeros = np.zeros((STEPS, COUNT))
    return Recording(
        period=PERIOD,
        command=command,
        alive=np.tile(alive, (STEPS, 1)),
        velocity=velocity,
        yaw=zeros,
        position=np.cumsum(velocity, axis=0) * PERIOD,
        foot_positions=np.zeros((STEPS, COUNT, 2, 3)),
        contacts=make_contacts(np.zeros((STEPS, COUNT, 2))),
        power=zeros,
        effort_share=zeros,
        speed_share=zeros,
        diverged=np.zeros(COUNT, dtype=bool),
        weight=np.full(COUNT, 120.0),
    )


def write(folder: Path, alive: list[bool]):
    out = folder / "out"
    out.mkdir(parents=True)
    inputs = []
    for case in (STOP, SIDE):
        inputs.append(folder / f"e{len(inputs)}")
        inputs[-1].mkdir()
        found = tuple(segments.measure(recording(case, np.array(alive)), protocol(), case))
        Evaluation("policy", None, random_robots(), case=case.name, segments=found).save(inputs[-1])
    section = {
        "name": "heldout",
        "evaluation": to_dict(protocol()),
        "labels": {"policy": "policy (ours)"},
    }
    summary = cases.run(section, {"evaluations": inputs}, out, Job(folder))
    rows = list(csv.DictReader((out / "heldout.csv").read_text().splitlines()))
    return summary, rows, out


def test_one_row_per_case(tmp_path):
    summary, rows, out = write(tmp_path, [True] * COUNT)
    assert [row["case"] for row in rows] == [STOP.name, SIDE.name]
    assert [row["seconds"] for row in rows] == ["10", "10"]
    assert [row["vx_before"] for row in rows] == ["0.4", ""]
    assert [row["vy_command"] for row in rows] == ["0", "0.1"]
    assert summary == {"rows": 2, "success_rate": {"policy": 1.0}}
    assert {path.name for path in out.iterdir()} == {
        f"heldout.{suffix}" for suffix in ("csv", "md", "svg", "png")
    }


def test_the_fastest_robot_is_a_maximum_and_standing_a_share(tmp_path):
    _, (stop, side), _ = write(tmp_path, [True] * COUNT)
    assert float(stop["fastest"]) == pytest.approx(0.2, abs=0.03)  # robot 2, not the mean
    assert float(stop["standing_rate"]) == 0.75
    ends = float(stop["standing_low"]), float(stop["standing_high"])
    assert ends == pytest.approx(wilson(3, 4), rel=1e-5)
    moved = np.array([0.0, 0.05, 0.2, 0.02 * 2**0.5]) * 3.0  # 7 to 10 s; the sway cancels
    assert float(stop["drift"]) == pytest.approx(moved.mean(), abs=0.02)
    assert float(stop["drift_max"]) == pytest.approx(moved.max(), abs=0.02)
    assert {side[name] for name in cases.STOPPED} == {""}


def test_sideways_has_its_mean_and_its_error(tmp_path):
    _, (_, side), _ = write(tmp_path, [True] * COUNT)
    late = round(3.0 / PERIOD)
    lateral = recording(SIDE, np.ones(COUNT, dtype=bool)).velocity[late:, :, 1].mean(axis=0)
    assert float(side["vy"]) == pytest.approx(lateral.mean(), rel=1e-5)
    assert float(side["vy_error"]) == pytest.approx(np.abs(lateral - 0.1).mean(), rel=1e-5)


def test_a_constant_command_has_table_1s_error(tmp_path):
    """The same number from another module, which knows neither segments nor cases."""
    _, (_, side), _ = write(tmp_path, [True] * COUNT)
    found = tracking(recording(SIDE, np.ones(COUNT, dtype=bool)), 3.0, 0.1, 0.1)
    assert float(side["mse_steady"]) == pytest.approx(found.squared_error_steady.mean(), rel=1e-5)


def test_a_robot_that_fell_does_not_stand_and_has_no_part_in_the_means(tmp_path):
    summary, (stop, _), _ = write(tmp_path, [True, False, False, True])
    assert float(stop["success_rate"]) == float(stop["standing_rate"]) == 0.5
    assert float(stop["fastest"]) < 0.1
    assert summary["success_rate"] == {"policy": 0.5}


def test_where_all_fall_there_are_no_numbers(tmp_path):
    _, rows, out = write(tmp_path, [False] * COUNT)
    assert {row["success_rate"] for row in rows} == {"0"}
    assert {row[name] for row in rows for name in cases.MEANS} == {""}
    assert (rows[0]["standing_rate"], rows[0]["fastest"]) == ("0", "")
    text = (out / "heldout.md").read_text()
    assert f"| {STOP.name} | 10 | 0 [0, 49] | 0 [0, 49] | – |" in text


def test_same_input_same_bytes(tmp_path):
    _, _, one = write(tmp_path / "one", [True] * COUNT)
    _, _, other = write(tmp_path / "other", [True] * COUNT)
    for path in one.iterdir():
        assert path.read_bytes() == (other / path.name).read_bytes(), path.name
