"""The stages: chunks of gaits, their collection, and what ends it."""

import importlib.util
import json
from copy import deepcopy
from pathlib import Path

import pandas as pd
import pytest

from pipeline.stages.entries import STAGES
from slider.artefacts.recipe import SOURCE_ROOT, closure
from slider.core import tables
from slider.core.errors import UserError
from slider.core.job import Job
from slider.robot.names import VELOCITY
from slider.verification import stage, summary
from slider.verification.quantities import QUANTITIES
from tests.verification.sample import VELOCITIES, jobs, library


@pytest.fixture(scope="module")
def checked(tmp_path_factory) -> list[Path]:
    """Results of all chunks."""
    folders = []
    for spec in jobs()[0]:
        folders.append(tmp_path_factory.mktemp("chunk"))
        stage.run_gaits(dict(spec.section), {"library": [library()]}, folders[-1], Job(Path()))
    return folders


def collect(checked, out: Path, **settings) -> None:
    section = deepcopy(dict(jobs()[1].section))
    section["verification"]["bounds"] |= settings.pop("bounds", {})
    section["verification"] |= settings
    out.mkdir(exist_ok=True)
    stage.run(section, {"library": [library()], "gaits": checked}, out, Job(Path()))


def test_table_and_summary_are_complete_and_the_same_bytes_again(checked, tmp_path):
    spec = jobs()[0][1]
    stage.run_gaits(dict(spec.section), {"library": [library()]}, tmp_path, Job(tmp_path))
    assert (tmp_path / stage.RECORDS).read_bytes() == (checked[1] / stage.RECORDS).read_bytes()
    first, second = (tmp_path / name for name in ("first", "second"))
    for out in (first, second):
        collect(checked, out)
    for name in (stage.CSV, stage.MARKDOWN):
        assert (first / name).read_bytes() == (second / name).read_bytes()
    rows = tables.read(first / stage.CSV)
    assert [*zip(rows["vx"], rows["vy"], strict=True)] == VELOCITIES
    assert {*rows} == {"vx", "vy", "yaw_rate", "failed", *QUANTITIES}
    assert rows["failed"].isna().all()
    assert all(f"`{name}`" in (first / stage.MARKDOWN).read_text() for name in QUANTITIES)


def test_a_bound_that_does_not_hold_ends_the_job_or_is_written_down(checked, tmp_path):
    with pytest.raises(UserError, match=r"gait \(0.6, -0.1\) m/s, roll_end: expected ≤ 1e-12") as e:
        collect(checked, tmp_path, bounds={"roll_end": 1e-12}, on_failure="error")
    assert "\n" not in str(e.value)
    assert not list(tmp_path.iterdir())
    collect(checked, tmp_path, bounds={"roll_end": 1e-12})
    assert (tables.read(tmp_path / stage.CSV)["failed"] == "roll_end").all()


def test_holes_of_the_library_are_left_out(tmp_path):
    section = dict(jobs()[0][0].section) | {"velocities": [[2.0, 0.0, 0.0]]}
    job = Job(tmp_path)
    assert stage.run_gaits(section, {"library": [library()]}, tmp_path, job) == {"gaits": 0}
    assert json.loads((tmp_path / stage.RECORDS).read_text()) == []


def test_without_pinocchio_one_line_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    message = r"^expected pinocchio, found none: pip install 'slider-ehzd\[verify\]'$"
    section = dict(jobs()[0][0].section)
    with pytest.raises(UserError, match=message):
        stage.run_gaits(section, {"library": [library()]}, tmp_path, Job(tmp_path))


def test_the_checks_share_nothing_with_the_optimisation():
    modules = closure(STAGES["verification"].entry.partition(":")[0], SOURCE_ROOT)[0]
    assert not [name for name in modules if name.startswith(("slider.gait", "slider.robot.bodies"))]
    assert "slider.verification.pin_robot" in modules


NONE: dict[str, float | None] = dict.fromkeys(QUANTITIES)


def table(*rows: tuple[float, dict[str, float]]) -> pd.DataFrame:
    """Gaits of some speeds [m/s] and their values."""
    records = [dict(zip(VELOCITY, (speed, 0.0, 0.0), strict=True)) | row for speed, row in rows]
    return pd.DataFrame(records).reindex(columns=[*VELOCITY, *QUANTITIES])


ROWS = table(
    (0.2, {"dynamics_torque": 1e-9, "dense_leg_distance": 0.11, "dense_cop": 0.4}),
    (0.3, {"dynamics_torque": 1e-3, "dense_leg_distance": 0.02, "dense_cop": 0.5}),
    (0.4, {"dynamics_torque": float("inf")}),
)


def test_values_beyond_a_bound_fail_and_infinite_ones_too():
    table, lines = summary.judge(ROWS, {"dynamics_torque": 1e-6, "dense_leg_distance": 0.03})
    assert table["failed"].tolist() == ["", "dynamics_torque dense_leg_distance", "dynamics_torque"]
    assert lines[0] == "gait (0.3, 0) m/s, dynamics_torque: expected ≤ 1e-06 N m, found 0.001"
    assert lines[1].endswith("found inf")
    assert "expected ≥ 0.03" in lines[2]
    assert summary.judge(ROWS, NONE)[1] == []


def test_worst_values_name_their_gaits(tmp_path):
    bounds = NONE | {"dynamics_torque": 1e-6}
    table, failures = summary.judge(ROWS[:2], bounds)
    summary.write_markdown(tmp_path / "a.md", table, bounds, failures)
    lines = (tmp_path / "a.md").read_text().splitlines()
    assert lines[0] == "2 gaits, 1 bounds. **1 values are beyond their bounds.**"
    ends = ("0.001 | 0.3, 0 | 0.0005 | ≤ 1e-06 **(not held)** |", "0.02 | 0.3, 0 | 0.065 | – |")
    assert all(any(line.endswith(end) for line in lines) for end in ends)
    assert not any("roll_end" in line for line in lines)
