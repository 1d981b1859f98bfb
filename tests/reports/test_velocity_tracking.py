"""Forward velocity over time as a target: its table, its figure, and what is left out."""

from pathlib import Path

import numpy as np
import pytest

from pipeline.stages import table1_jobs
from pipeline.stages.evaluation import velocity_tracking as lay_out
from slider.config.compose import compose
from slider.core.errors import UserError
from slider.core.job import Job
from slider.evaluation.results import Evaluation
from slider.reports import rows
from slider.reports.velocity_tracking import NAME, run
from tests.evaluation.test_results import make_robots

CONF = Path(__file__).parents[2] / "conf"
LABELS = {"policy": "policy (ours)", "mpc": "MPC + WBC"}
TRACE = np.array([[0.1, 0.01], [0.3, 0.02], [0.4, 0.0]], dtype=np.float32)


def write_evaluation(folder: Path, controller: str, command: float, survived: int = 1) -> Path:
    folder.mkdir(parents=True)
    robots = make_robots([[survived, survived]], [[1.0, 2.0]])
    Evaluation(controller, command, robots, TRACE).save(folder)
    return folder


def written(folder: Path, *found: Path) -> Path:
    folder.mkdir()
    section = {"commands": [0.4, 3.0], "control_period": 0.02, "labels": LABELS}
    run(section, {"evaluations": list(found)}, folder, Job(folder))
    return folder


def test_a_row_per_controller_command_and_control_step(tmp_path):
    found = [
        write_evaluation(tmp_path / "a", "policy", 0.4),
        write_evaluation(tmp_path / "b", "mpc", 0.4, survived=0),
    ]
    out = written(tmp_path / "out", *found)
    names = {f"{NAME}.{suffix}" for suffix in ("csv", "md", "svg", "png")}
    assert {path.name for path in out.iterdir()} == names
    ours, others = rows.by(rows.read(out / f"{NAME}.csv"), "label").values()
    assert [row["time"] for row in ours] == [0.02, 0.04, 0.06]
    assert [row["mean_velocity"] for row in ours] == [0.1, 0.3, 0.4]
    assert [row["mean_velocity_spread"] for row in ours] == [0.01, 0.02, 0.0]
    assert np.isnan([row["mean_velocity"] for row in others]).all()  # of nobody
    text = (out / f"{NAME}.md").read_text()
    assert "Not evaluated in this run, and therefore not drawn: 3.0 m/s." in text
    assert "Nobody survived, and therefore not drawn: MPC + WBC at 0.4 m/s." in text


def test_same_input_same_bytes(tmp_path):
    found = write_evaluation(tmp_path / "a", "policy", 0.4)
    one, other = (written(tmp_path / name, found) for name in ("one", "other"))
    for path in one.iterdir():
        assert path.read_bytes() == (other / path.name).read_bytes(), path.name


def test_a_command_must_be_evaluated(tmp_path):
    message = r"^report\.tracking_commands: expected at least one of evaluation\.commands, found "
    with pytest.raises(UserError, match=message + r"\[0\.4, 3\.0\]$"):
        written(tmp_path / "out")


def test_the_job_waits_for_the_commands_that_it_shows_alone():
    config = compose(["experiment=test", "report.tracking_commands=[0.4,7.0]"], CONF)
    table1 = table1_jobs(config)["table1"]
    inputs = lay_out(config, table1).inputs["evaluations"]
    assert [one for one in table1.inputs["evaluations"] if one in inputs] == list(inputs)
    assert {one.section["command"] for one in inputs} == {0.4}
    assert len(inputs) == len(config.evaluation.controllers)
