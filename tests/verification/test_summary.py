"""Bounds, verdicts and files."""

import csv

import pandas as pd
import pytest

from slider.robot.names import VELOCITY
from slider.verification import summary
from slider.verification.quantities import QUANTITIES

NONE: summary.Bounds = dict.fromkeys(QUANTITIES)


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
    failed = summary.failures(ROWS, {"dynamics_torque": 1e-6, "dense_leg_distance": 0.03})
    assert [failure.velocity[0] for failure in failed] == [0.3, 0.4, 0.3]
    assert failed[0].text == "gait (0.3, 0) m/s, dynamics_torque: expected ≤ 1e-06 N m, found 0.001"
    assert "expected ≥ 0.03" in failed[2].text
    assert summary.failures(ROWS, NONE) == []


def test_worst_values_name_their_gaits():
    worst = summary.worst(ROWS[:2], NONE | {"dynamics_torque": 1e-6})
    torque, distance = worst["dynamics_torque"], worst["dense_leg_distance"]
    assert (torque["worst"], torque["vx"], torque["passed"]) == (1e-3, 0.3, False)
    assert torque["median"] == pytest.approx(5e-4, rel=1e-3)
    assert (distance["worst"], distance["vx"], distance["passed"]) == (0.02, 0.3, None)
    assert "roll_end" not in worst
    assert summary.worst(ROWS, NONE)["dynamics_torque"]["worst"] is None


def test_files(tmp_path):
    failed = summary.failures(ROWS, NONE | {"dynamics_torque": 1e-6})
    summary.write_csv(tmp_path / "a.csv", ROWS, failed)
    rows = list(csv.DictReader((tmp_path / "a.csv").read_text().splitlines()))
    assert [row["failed"] for row in rows] == ["", "dynamics_torque", "dynamics_torque"]
    assert rows[0]["dense_leg_distance"] == "0.11"
    assert rows[2]["dense_leg_distance"] == ""
    quantities = summary.worst(ROWS[:2], NONE | {"dynamics_torque": 1e-6})
    summary.write_markdown(tmp_path / "a.md", ROWS[:2], quantities, failed)
    lines = (tmp_path / "a.md").read_text().splitlines()
    assert any(
        line.endswith("0.001 | 0.3, 0 | 0.0005 | ≤ 1e-06 **(not held)** |") for line in lines
    )
    assert lines[0] == "2 gaits, 1 bounds. **2 values are beyond their bounds:**"
    assert [line.partition(",")[0] for line in lines[2:4]] == [
        f"* {failed[0].text.partition(',')[0]}",
        "* gait (0.4",
    ]
    assert lines[-1] == "| `dense_cop` | 0.4 | 0.5 |"
