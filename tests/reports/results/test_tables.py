"""Each table of the documentation from a report whose numbers are known."""

import json
from pathlib import Path

import pytest

from slider.artefacts.store import Store
from slider.reports.results.tables import TABLES, Unmade

HELDOUT = """\
controller,label,case,seconds,vx_before,vx_command,vy_command,success_rate,success_low,success_high,mse_steady,vx,vy,vy_error,heading_error,standing_rate,standing_low,standing_high,fastest,drift,drift_max
policy,ours,0.3 m/s,66,,0.3,0,1,0.963,1,0.001,0.301,0,0,0.05,,,,,,
policy,ours,stop from 1.2 m/s,66,1.2,0,0,1,0.963,1,0.0001,0,0,0,0.05,0.98,0.93,0.995,0.12,0.02,0.1
policy,ours,left,16,,0.6,0.1,1,0.963,1,0.002,0.6,0.09,0.01,0.05,,,,,,
"""
SWEEP = """\
controller,label,command_velocity,tracking_rate
policy,ours,0,1
policy,ours,0.1,0.5
policy,ours,3,0.95
mpc_wbc_tuned,"MPC + WBC, tuned",0,0.2
"""
TABLE1 = """\
controller,label,source,command_velocity,success_rate,mse,mse_steady
policy,ours,measured,0.2,1,0.01,0.002
policy,ours,measured,3,0,inf,inf
mpc_wbc_literal,literal,measured,0.2,1,0.01,0.002
guided_drl,paper,paper,0.2,0.731,0.0317,
"""
ABLATION = """\
# Ablation

Means.

![Ablation](figures/ablation.png)

## Success rate [%]

| variant | 0.4 m/s |
|---|---|
| default | 100.0 |
"""


def make(name: str, text: str, folder: Path) -> str:
    table = TABLES[name]
    report = folder / table.report
    report.write_text(text)
    return table.make(report, Store(folder / "artefacts"))


def test_held_out_commands_are_three_tables(tmp_path):
    speeds, standing, sideways = make("heldout", HELDOUT, tmp_path).split("\n\n**")
    assert "| 0.3 m/s | 66 | 100 [96.3, 100] | 0.301 | 0 | 0.00100 | 0.0500 |" in speeds
    assert "| stop from 1.2 m/s | 66 | 100 [96.3, 100] | 98 [93, 99.5] | 0.120 |" in standing
    assert "| left | 16 | 100 [96.3, 100] | 0.0900 | 0.0100 | 0.600 |" in sideways


def test_the_highest_tracked_speed_and_what_is_lost_below(tmp_path):
    lines = make("sweep", SWEEP, tmp_path).splitlines()
    assert lines[2:] == ["| ours | 3.0 | 0.1 |", "| MPC + WBC, tuned | none | none |"]


def test_the_summary_has_a_line_per_command(tmp_path):
    lines = make("summary", TABLE1, tmp_path).splitlines()
    shown = "success [%], ours | success [%], paper | MSE [m²/s²], ours | MSE [m²/s²], paper"
    assert lines[0] == f"| command [m/s] | {shown} |"
    assert lines[2:] == [
        "| 0.2 | 100 | 73.1 | 0.00200 | 0.0317 |",
        "| 3.0 | 0 | – | ∞ | – |",
    ]


def test_the_ablation_has_neither_title_nor_figure(tmp_path):
    text = make("ablation", ABLATION, tmp_path)
    assert text.startswith("Means.\n\n**Success rate [%]**\n\n| variant | 0.4 m/s |")


def test_the_convergence_of_the_gaits_begins_with_its_first_table(tmp_path):
    report = "# Gaits\n\n![Gaits](figures/a.png)\n\n## Meshes\n\n| nodes |\n|---|\n| 5 |\n"
    text = make("gait_convergence", report, tmp_path)
    assert text == "**Meshes**\n\n| nodes |\n|---|\n| 5 |"


def test_the_verification_counts_its_bounds(tmp_path):
    found = {
        "worst": 0.5,
        "vx": 1.2,
        "vy": -0.1,
        "yaw_rate": 0.0,
        "median": 0.1,
        "bound": 0.4,
        "passed": False,
    }
    about = {"gaits": 179, "quantities": {"roll_end": found}}
    text = make("verification", json.dumps(about), tmp_path)
    assert text.startswith("179 gaits; 0 of 1 bounds hold for all of them.")
    assert "| roll_end |" in text
    assert "| 0.5 | ≤ 0.4 | NO | 1.2, -0.1 | 0.1 |" in text


def test_times_need_the_store(tmp_path):
    with pytest.raises(Unmade, match=r"table1\.csv is of no job in the store"):
        make("times", "controller\n", tmp_path)
