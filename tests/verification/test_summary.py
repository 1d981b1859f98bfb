"""Bounds and verdicts."""

import pandas as pd

from slider.robot.names import VELOCITY
from slider.verification import summary
from slider.verification.quantities import QUANTITIES

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
