"""Tables, verdict and figure of the study of the gaits from results whose answers are known."""

import json
from pathlib import Path

import numpy as np
import pytest

from slider.core.job import Job
from slider.gait import REPORT
from slider.reports.gait_convergence import mesh_rows, run, start_rows
from slider.reports.gait_convergence_text import LIBRARY
from slider.reports.rows import by, read

SPREAD = {"joints": 0.5, "crouch": {"lower": 0.3, "upper": 1.2}, "stride": {"lower": 1, "upper": 1}}
SECTION = {
    "study": {
        "commands": [0.4, 1.2],
        "nodes": [5, 9],
        "same_cost": 1e-4,
        "starts": {"number": 4, "seed": 1, "spread": SPREAD},
    },
    "max_violation": 1e-6,
}
# Cost of the library's gait and of the starts; None: IPOPT fails; negative: a residual is too large
COSTS = {0.4: (100.0, [100.001, None, 103.0, -90.0]), 1.2: (204.0, [200.0, 200.01, 204.0, 204.0])}


def solve(folder: Path, cost: float | None, nodes: int = 0, offset: float = 0.0) -> Path:
    folder.mkdir()
    worst = 1e-3 if cost is not None and cost < 0 else 1e-8
    report = {
        "converged": cost is not None,
        "status": "Infeasible_Problem_Detected" if cost is None else "Solve_Succeeded",
        "iterations": 25,
        "cost": abs(cost or 7.0),
        "max_violation": worst,
        "residuals": {"impact": worst, "friction": 0.0},
        "between_nodes": {"foot_line_moment": 0.5, "clearance": 0.002, "torso": 0.0},
    }
    (folder / REPORT).write_text(json.dumps(report))
    if nodes:
        joints = np.full((2 * nodes, 10), offset)
        np.save(folder / "knee_positions.npy", joints)
        np.save(folder / "knee_torques.npy", np.full((2 * nodes, 10), np.sqrt(1.0 + offset)))
        np.save(folder / "roll.npy", np.zeros((2, nodes, 3)))
        np.save(folder / "step_time.npy", np.full(2, 0.4))
    return folder


@pytest.fixture(scope="module")
def inputs(tmp_path_factory) -> dict[str, list[Path]]:
    """The fine mesh of 1.2 m/s does not converge; the coarse one of 0.4 m/s is 0.1 rad away."""
    folder = tmp_path_factory.mktemp("solves")
    meshes = [(100.0, 5, 0.1), (100.0, 9, 0.0), (200.0, 5, 0.0), (None, 9, 0.0)]
    return {
        "meshes": [solve(folder / f"mesh{i}", *mesh) for i, mesh in enumerate(meshes)],
        "library": [solve(folder / f"library{v}", own) for v, (own, _) in COSTS.items()],
        "starts": [
            solve(folder / f"start{v}_{i}", cost)
            for v, (_, costs) in COSTS.items()
            for i, cost in enumerate(costs)
        ],
    }


@pytest.fixture(scope="module")
def out(inputs, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("out")
    times = {name: [{"solve_cpu": 2.5}] * len(found) for name, found in inputs.items()}
    job = Job(folder, input_volatile=times)
    assert run(SECTION, inputs, folder, job) == {"failed_meshes": 1, "failed_starts": 2}
    return folder


def test_meshes_are_compared_with_the_finest_that_converges(inputs):
    rows = mesh_rows(SECTION, inputs, Job(Path()))
    assert [(row["command"], row["nodes"]) for row in rows] == [
        (0.4, 5),
        (0.4, 9),
        (1.2, 5),
        (1.2, 9),
    ]
    coarse, fine, *others = rows
    assert coarse["joints_difference"] == pytest.approx(0.1)
    assert coarse["torque_cost_difference"] == pytest.approx(0.1)
    assert fine["joints_difference"] == 0
    assert all(np.isnan(row["joints_difference"]) for row in others)
    assert coarse["worst_constraint"] == "impact"


def test_starts_are_judged_by_the_library_s_criterion_and_grouped_by_cost(inputs):
    rows = by(start_rows(SECTION, inputs, Job(Path())), "command")
    assert [row["start"] for row in rows[0.4]] == [LIBRARY, 0, 1, 2, 3]
    assert [row["converged"] for row in rows[0.4]] == [1, 1, 0, 1, 0]
    np.testing.assert_array_equal([row["optimum"] for row in rows[0.4]], [0, 0, np.nan, 1, np.nan])
    assert [row["optimum"] for row in rows[1.2]] == [1, 0, 0, 1, 1]
    assert rows[1.2][0]["cost_excess"] == pytest.approx(0.02)


def test_the_tables_say_shares_and_whether_the_library_s_gait_is_the_best(out):
    text = (out / "gait_convergence.md").read_text()
    assert "| 0.4 | 4 | 50 [15, 85] | 25 [4.6, 69.9] | 2 | 0 % | 25 | 2.5 |" in text
    assert "| 1.2 | 4 | 100 [51, 100] | 50 [15, 85] | 2 | 2 % | 25 | 2.5 |" in text
    assert "At 0.4 m/s 2 of 4 starts did not converge (" in text
    assert "At 0.4 m/s no start finds a better gait than the library's." in text
    assert "At 1.2 m/s the library's gait costs 2 % more than the best one found." in text
    assert (
        "| 0.4 | 5 | yes | 25 | 22 | +10 % | 0.4 | 1e-08 impact | 0.5 | 0.002 clearance |" in text
    )


def test_times_stand_in_the_markdown_alone(out):
    for name in ("gait_convergence.csv", "gait_starts.csv"):
        assert "solve_cpu" not in (out / name).read_text()
    rows = read(out / "gait_starts.csv")
    assert len(rows) == 2 * (1 + 4)
    assert (out / "gait_convergence.svg").stat().st_size > 10_000


def test_the_same_results_give_the_same_files(inputs, out, tmp_path):
    run(SECTION, inputs, tmp_path, Job(tmp_path))
    for name in ("gait_convergence.csv", "gait_starts.csv", "gait_convergence.svg"):
        assert (tmp_path / name).read_bytes() == (out / name).read_bytes()
