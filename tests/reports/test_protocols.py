"""Reports of the protocols and of velocities over time, from rollouts whose answers are known."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pipeline.stages import table1_jobs
from pipeline.stages.evaluation import speed_of, velocity_tracking
from slider.config.convert import to_dict
from slider.config.evaluation import CaseConfig, EvaluationConfig, ProfileConfig, Segment
from slider.core import tables
from slider.core.errors import UserError
from slider.core.job import Job
from slider.env.metrics import tracking
from slider.env.rollout import Recording
from slider.evaluation import segments
from slider.evaluation.results import AXES, Evaluation, wilson
from slider.evaluation.segments import velocities
from slider.reports import protocols
from tests.config.composed import composed
from tests.env.synthetic import config, make_recording
from tests.evaluation.test_results import changing, make_robots, random_robots
from tests.evaluation.test_segments import protocol

LABELS = {"policy": "policy (ours)", "mpc": "MPC + WBC"}
PERIOD, SECONDS, COUNT = 0.02, 10.0, 4
STEPS = round(SECONDS / PERIOD)
STOP = CaseConfig(
    "stop from 0.4 m/s", [Segment("walk", 0.0, 0.4, 0.0, 0.0), Segment("stop", 4.0, 0.0)]
)
SIDE = CaseConfig("0.4 m/s leftward", [Segment("walk", 0.0, 0.4, 0.1)])


def cases_protocol() -> EvaluationConfig:
    whole = config("experiment=test").evaluation
    profile = ProfileConfig(0.0, 3.0, 0.8, "cases", [STOP, SIDE])
    return replace(whole, profile=profile, duration=SECONDS, trials=2, robots=2, speeds=[])


def case_recording(case: CaseConfig, alive: np.ndarray) -> Recording:
    """Robot 0 tracks exactly; 1 goes on with 0.05 and 2 with 0.2 m/s after 4 s; 3: 0.02 m/s off."""
    command = np.repeat(velocities(case, 0.0, SECONDS, PERIOD)[:, None], COUNT, axis=1)
    velocity = command[:, :, :2].copy()
    late = round(4.0 / PERIOD)
    velocity[late:, 1, 1] += 0.05
    velocity[late:, 2, 0] += 0.2
    velocity[:, 3] += 0.02
    velocity[::2, 1:] += 0.5  # sway that a mean over half a second does not show
    velocity[1::2, 1:] -= 0.5
    position = np.cumsum(velocity, axis=0) * PERIOD
    up = np.tile(alive, (STEPS, 1))
    return make_recording(command, alive=up, velocity=velocity, position=position)


def report(folder: Path, name: str, config: EvaluationConfig, evaluations: list[Evaluation]):
    """A protocol's report: its summary, its rows, and the folder of its files."""
    section = {"name": name, "evaluation": to_dict(config), "labels": LABELS, "robot": "mine"}
    inputs, out = write_all(folder, evaluations)
    summary = protocols.run(section, {"evaluations": inputs}, out, Job(folder))
    ends = {"csv", "md"} if name == "heldout" else {"csv", "md", "svg"}
    assert {path.name for path in out.iterdir()} == {f"{name}.{end}" for end in ends}
    return summary, tables.read(out / f"{name}.csv"), out


def write_all(folder: Path, evaluations: list[Evaluation]) -> tuple[list[Path], Path]:
    """Folders of evaluations, and an empty one for what is made of them."""
    *inputs, out = (folder / str(index) for index in range(len(evaluations) + 1))
    out.mkdir(parents=True)
    for one, target in zip(evaluations, inputs, strict=True):
        target.mkdir()
        one.save(target)
    return inputs, out


def report_cases(folder: Path, alive: list[bool]):
    protocol, evaluations = cases_protocol(), []
    for one in (STOP, SIDE):
        robots = segments.measure(case_recording(one, np.array(alive)), protocol, one)
        found = Evaluation("policy", None, random_robots(), case=one.name, segments=robots)
        evaluations.append(found)
    return report(folder, "heldout", protocol, evaluations)


@pytest.fixture(scope="module")
def cases(tmp_path_factory):
    """The report of robots that all survive."""
    return report_cases(tmp_path_factory.mktemp("cases"), [True] * COUNT)


def test_each_case_has_a_row_its_fastest_robot_and_the_share_that_stands(cases):
    summary, rows, _ = cases
    found = rows[["case", "seconds", "vx_before", "vy_command"]].fillna("").to_numpy().tolist()
    assert found == [[STOP.name, 10, 0.4, 0], [SIDE.name, 10, "", 0.1]]
    assert summary == {"rows": 2, "success_rate": {"policy": 1.0}}
    stop, side = rows.to_dict("records")
    assert stop["fastest"] == pytest.approx(0.2, abs=0.03)  # robot 2, not the mean
    standing = [stop[f"standing_{end}"] for end in ("rate", "low", "high")]
    assert standing == pytest.approx([0.75, *wilson(3, 4)], rel=1e-5)
    moved = np.array([0.0, 0.05, 0.2, 0.02 * 2**0.5]) * 3.0  # 7 to 10 s; the sway cancels
    assert stop["drift"] == pytest.approx(moved.mean(), abs=0.02)
    assert stop["drift_max"] == pytest.approx(moved.max(), abs=0.02)
    assert np.isnan([side[name] for name in protocols.STOPPED]).all()


def test_sideways_has_its_mean_and_its_errors(cases):
    """The squared error is Table 1's, of a module without segments and cases."""
    side, rollout = cases[1].iloc[1], case_recording(SIDE, np.ones(COUNT, dtype=bool))
    lateral = rollout.velocity[round(3.0 / PERIOD) :, :, 1].mean(axis=0)
    assert side["vy"] == pytest.approx(lateral.mean(), rel=1e-5)
    assert side["vy_error"] == pytest.approx(np.abs(lateral - 0.1).mean(), rel=1e-5)
    found = tracking(rollout, 3.0, 0.1, 0.1)["squared_error_steady"]
    assert side["mse_steady"] == pytest.approx(found.mean(), rel=1e-5)


def test_a_robot_that_fell_does_not_stand_and_has_no_part_in_the_means(tmp_path):
    """Where all fell there are no numbers."""
    summary, rows, _ = report_cases(tmp_path / "half", [True, False, False, True])
    assert rows["success_rate"][0] == rows["standing_rate"][0] == 0.5
    assert rows["fastest"][0] < 0.1
    assert summary["success_rate"] == {"policy": 0.5}
    _, rows, out = report_cases(tmp_path / "all", [False] * COUNT)
    assert rows[[*protocols.MEANS, "fastest"]].isna().all(axis=None)
    assert f"| {STOP.name} | 10 | 0 [0, 49] | 0 [0, 49] | – |" in (out / "heldout.md").read_text()


def test_one_row_per_segment_with_means_of_those_that_are_up(tmp_path):
    summary, rows, _ = report(tmp_path, "joystick", protocol(), [changing()])
    assert rows["segment"].tolist() == ["stand", "turn", "side"]
    turn = rows.iloc[1]
    assert [turn[f"{axis}_command"] for axis in AXES] == [0.4, 0, 0.3]
    assert (turn["success_rate"], rows["success_rate"][0]) == (0.75, 1)
    assert turn["vx_error"] == pytest.approx(0.5 / 3, rel=1e-5)
    assert turn["yaw_rate_error"] == pytest.approx(0.4 / 3, rel=1e-5)
    assert summary == {"rows": 3, "success_rate": {"policy": 0.75}}


def test_speeds(tmp_path):
    walks = make_robots([[1, 1], [1, 1]], [[0.5, 0.25], [0.125, 1.0]])
    falls = make_robots([[0, 0], [0, 0]], [[1, 1], [1, 1]])
    evaluations = [Evaluation("policy", 0.2, walks), Evaluation("policy", 3.0, falls)]
    sweep = config("experiment=test").protocols["sweep"]
    summary, rows, out = report(tmp_path, "sweep", sweep, evaluations)
    velocity = np.array([1.5, 1.25, 1.125, 2.0])  # errors + 1
    walks = {"speed": 0.2, "success_rate": 1, "mean_velocity": velocity.mean()}
    walks["mean_velocity_spread"] = velocity.std()
    assert rows.iloc[0][[*walks]].to_dict() == pytest.approx(walks, rel=1e-5)
    falls = {"speed": 3, "success_rate": 0, "mse_steady": np.inf, "mean_velocity": np.nan}
    assert rows.iloc[1][[*falls]].to_dict() == pytest.approx(falls, nan_ok=True)
    assert summary == {"rows": 2, "highest_tracked": {"policy": None}}
    text = (out / "sweep.md").read_text()
    assert "![Sweep](figures/sweep.svg)" in text
    assert "| 0.2 | 1.469 ± 0.335 |\n| 3.0 | – |" in text


def test_the_highest_tracked_speed_has_the_mean_speed_of_its_robots(tmp_path):
    walk, fall = make_robots([[1], [1]], [[0.5], [0.3]]), make_robots([[0], [0]], [[1], [1]])
    speeds = {0.2: fall, 1.2: walk, 2.2: walk, 3.0: fall}
    evaluations = [Evaluation("policy", *one) for one in speeds.items()]
    out = report(tmp_path, "sweep", config("experiment=test").protocols["sweep"], evaluations)[2]
    assert "| policy (ours) | 2.2 | 1.40 | 0.2 |" in (out / "sweep.md").read_text()


def test_the_highest_tracked_speed():
    shares = {"controller": "p", "speed": [0.2, 2.2, 3.0], "tracking_rate": [1.0, 0.9, 0.89]}
    assert protocols.highest_tracked(pd.DataFrame(shares)) == {"p": 2.2}


TRACE = np.array([[0.1, 0.01], [0.3, 0.02], [0.4, 0.0]], dtype=np.float32)


def report_tracking(folder: Path, *controllers: str) -> Path:
    """The stage's files; nobody survives with the controller ``mpc``."""
    evaluations = [
        Evaluation(
            name, 0.4, make_robots([[walks] * 2], [[1.0, 2.0]]), TRACE if walks else np.nan * TRACE
        )
        for name, walks in ((name, name != "mpc") for name in controllers)
    ]
    inputs, out = write_all(folder, evaluations)
    section = {"speeds": [0.4, 3.0], "control_period": 0.02, "labels": LABELS, "robot": "mine"}
    protocols.run_tracking(section, {"evaluations": inputs}, out, Job(folder))
    return out


def test_tracking_has_a_row_per_controller_speed_and_control_step(tmp_path):
    out = report_tracking(tmp_path, "policy", "mpc")
    name = protocols.TRACKING
    assert {path.name for path in out.iterdir()} == {f"{name}.{x}" for x in ("csv", "md", "svg")}
    frame = tables.read(out / f"{name}.csv")
    (_, ours), (_, others) = frame.groupby("label", sort=False)
    found = ours[["time", "mean_velocity", "mean_velocity_spread"]].to_numpy().tolist()
    assert found == [[0.02, 0.1, 0.01], [0.04, 0.3, 0.02], [0.06, 0.4, 0.0]]
    assert others["mean_velocity"].isna().all()  # nobody survived


def test_tracking_needs_an_evaluated_speed(tmp_path):
    message = r"^report\.tracking_speeds: expected at least one of evaluation\.speeds, found "
    with pytest.raises(UserError, match=message + r"\[0\.4, 3\.0\]$"):
        report_tracking(tmp_path)


def test_the_job_waits_for_the_speeds_that_it_shows_alone():
    config = composed("experiment=test", "report.tracking_speeds=[0.4,7.0]")
    table1 = table1_jobs(config)["table1"]
    inputs = velocity_tracking(config, table1).inputs["evaluations"]
    assert [one for one in table1.inputs["evaluations"] if one in inputs] == list(inputs)
    assert [speed_of(one) for one in inputs] == [0.4]
