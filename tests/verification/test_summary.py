"""Bounds, verdicts and files."""

import csv

import pandas as pd
import pytest

from slider.core.errors import UserError
from slider.robot.names import VELOCITY
from slider.verification import summary
from slider.verification.quantities import QUANTITIES
from tests.verification.sample import config

NONE: summary.Bounds = dict.fromkeys(QUANTITIES)


def table(*rows: tuple[float, dict[str, float]]) -> pd.DataFrame:
    """Gaits of some speeds [m/s] and their values."""
    records = [dict(zip(VELOCITY, (speed, 0.0, 0.0), strict=True)) | row for speed, row in rows]
    return pd.DataFrame(records).reindex(columns=[*VELOCITY, *QUANTITIES])


ROWS = table(
    (0.2, {"dynamics_torque": 1e-9, "regulated_steps": 30.0}),
    (0.3, {"dynamics_torque": 1e-3, "regulated_steps": 4.0}),
    (0.4, {"dynamics_torque": float("inf")}),
)


def test_every_quantity_has_a_bound_or_none():
    summary.check_names(config().verification.bounds)


@pytest.mark.parametrize(
    ("bounds", "message"),
    [
        (NONE | {"dynamics_torqe": 1.0}, "unknown dynamics_torqe"),
        ({n: b for n, b in NONE.items() if n != "return_map"}, "none for return_map"),
    ],
)
def test_other_names_are_refused(bounds, message):
    with pytest.raises(UserError, match=message):
        summary.check_names(bounds)


def test_values_beyond_a_bound_fail_and_infinite_ones_too():
    failed = summary.failures(ROWS, NONE | {"dynamics_torque": 1e-6})
    assert [failure.velocity for failure in failed] == [(0.3, 0.0, 0.0), (0.4, 0.0, 0.0)]
    assert str(failed[0]) == (
        "gait (0.3, 0) m/s, dynamics_torque: expected ≤ 1e-06 N m, found 0.001"
    )
    assert summary.failures(ROWS, NONE) == []


def test_some_bounds_are_lower_ones():
    failed = summary.failures(ROWS, NONE | {"regulated_steps": 10.0})
    assert [failure.velocity for failure in failed] == [(0.3, 0.0, 0.0)]
    assert "expected ≥ 10" in str(failed[0])


def test_worst_values_name_their_gaits():
    worst = summary.worst(ROWS[:2], NONE | {"dynamics_torque": 1e-6})
    torque, steps = worst["dynamics_torque"], worst["regulated_steps"]
    assert (torque["worst"], torque["vx"], torque["passed"]) == (1e-3, 0.3, False)
    assert torque["median"] == pytest.approx(5e-4, rel=1e-3)
    assert (steps["worst"], steps["vx"], steps["passed"]) == (4.0, 0.3, None)
    assert "roll_end" not in worst
    assert summary.worst(ROWS, NONE)["dynamics_torque"]["worst"] is None


def test_files(tmp_path):
    failed = summary.failures(ROWS, NONE | {"dynamics_torque": 1e-6})
    summary.write_csv(tmp_path / "a.csv", ROWS, failed)
    rows = list(csv.DictReader((tmp_path / "a.csv").read_text().splitlines()))
    assert [row["failed"] for row in rows] == ["", "dynamics_torque", "dynamics_torque"]
    assert rows[0]["regulated_steps"] == "30"
    assert rows[2]["regulated_steps"] == ""


def test_the_table_for_people_names_worst_gaits_and_what_does_not_hold(tmp_path):
    rows = ROWS[:2].assign(dense_torque=0.5)
    worst = summary.worst(rows, NONE | {"dynamics_torque": 1e-6, "regulated_steps": 1.0})
    summary.write_markdown(tmp_path / "a.md", rows, worst)
    lines = (tmp_path / "a.md").read_text().splitlines()
    assert lines[0] == "2 gaits."
    torque, steps = (
        next(line for line in lines if f"| `{name}` |" in line)
        for name in ("dynamics_torque", "regulated_steps")
    )
    assert torque.endswith("| 0.001 | 0.3, 0 | 0.0005 | ≤ 1e-06 **(not held)** |")
    assert steps.endswith("| 4 | 0.3, 0 | 17 | ≥ 1 |")
    assert "| vx [m/s] | 0.2 | 0.3 |" in lines
    assert lines[-2] == "| `regulated_steps` | 30 | 4 |"
    assert lines[-1] == "| `regulated_speed` | – | – |"
