"""Tables and figure of a study from results whose answers are known."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from slider.core.job import Job
from slider.evaluation.results import wilson
from slider.gait import REPORT
from slider.reports.study import ALL, SHOWN, run, strongest, summarise
from tests.evaluation.test_results import make_robots, write_evaluation
from tests.library.gaits import write_store

SPEEDS = [0.2, 0.8]
RUNS = [("default", 1), ("default", 2), ("hard", 1), ("hard", 2)]
CHECKS = ([0.0, 0.96], [0.97, 1.0], [0.0, 0.5], [0.0, 0.0])
TRAINED = {
    "name": "ablation",
    "robot": "mine",
    "metrics": ["success_rate", "mse_steady", "alternation", "samples_to_walk"],
    "variants": [
        ["default", "as it is", "", ""],
        ["hard", "hard", "gait.cost=torque env=paper", ""],
        ["none", "no robot", "", "no such robot: expected a leg, found none"],
    ],
    "keys": {
        "walking": [[*key, 100_000] for key in RUNS],
        "evaluations": [[*key, speed] for key in RUNS for speed in SPEEDS],
    },
    "max_violation": 1e-6,
    "same_cost": None,
}


def write_checks(folder: Path, success: list[float]) -> Path:
    """Checks after iterations 5, 10, …; without survivors there is no error and no flight."""
    folder.mkdir(parents=True)
    lines = ["iteration,value,success,speed_error,flight"]
    for index, share in enumerate(success):
        found = f"{0.1 * (index + 1)},0.02" if share else ","
        lines.append(f"{5 * (index + 1)},1,{share},{found}")
    (folder / "selection.csv").write_text("\n".join(lines) + "\n")
    return folder


@pytest.fixture(scope="module")
def out(tmp_path_factory) -> Path:
    """Errors of run i are 0.1 (i + 1) m²/s²; on the last run at 0.8 m/s all robots fall."""
    folder, out, evaluations = (*map(tmp_path_factory.mktemp, ("ablation", "out")), [])
    for index, _ in enumerate(RUNS):
        for speed in SPEEDS:
            alive = [[0, 0]] if (index, speed) == (3, 0.8) else [[1, 1]]
            errors = make_robots(alive, [[1.0 + index, 1.0 + index]])
            evaluations.append(write_evaluation(folder / f"e{len(evaluations)}", speed, errors))
    inputs = {
        "walking": [write_checks(folder / f"w{i}", checks) for i, checks in enumerate(CHECKS)],
        "evaluations": evaluations,
        "library": [write_store(folder / "gaits", [(0.0, 0.0), (1.0, 0.0)]).parent],
    }
    run(TRAINED, inputs, out, Job(out))
    return out


def at(path: Path, variant: str, metric: str, speed: float = 0.2) -> pd.Series:
    table = pd.read_csv(path)
    rows = table[(table["variant"] == variant) & (table["metric"] == metric)]
    (index,) = np.flatnonzero(rows["speed"].isna() | (rows["speed"] == speed))
    return rows.iloc[index]


def test_each_run_has_the_numbers_of_its_evaluation(out):
    ends = {".csv", "_runs.csv", "_curves.csv", ".md", ".svg"}
    assert {path.name for path in out.iterdir()} == {f"ablation{end}" for end in ends}
    runs = pd.read_csv(out / "ablation_runs.csv").dropna(subset="speed")
    assert [*zip(runs["variant"], runs["seed"], runs["speed"], strict=True)] == [
        (*key, speed) for key in RUNS for speed in SPEEDS
    ]
    errors = [0.1, 0.1, 0.2, 0.2, 0.3, 0.3, 0.4, np.inf]
    np.testing.assert_allclose(runs["mse_steady"], errors)
    assert runs["success_rate"].iloc[-1] == 0
    assert np.isnan(runs["alternation"].iloc[-1])
    assert (runs["reference_touchdown_rate"] > 0).all(), "of the library's gait, as in Table 1"
    row = pd.read_csv(out / "ablation.csv").iloc[-1]
    assert row["note"] == "no such robot: expected a leg, found none"  # with its comma
    assert np.isnan(row["mean"])


def test_means_spread_over_seeds_and_changes_are_paired(out):
    row = at(out / "ablation.csv", "hard", "mse_steady")
    assert (row["count"], row["mean"], row["min"], row["max"]) == (2, 0.35, 0.3, 0.4)
    assert row["std"] == pytest.approx(np.std([0.3, 0.4], ddof=1), rel=1e-5)
    expected = stats.t.interval(0.95, 1, loc=0.35, scale=stats.sem([0.3, 0.4]))
    np.testing.assert_allclose(row[["low", "high"]].tolist(), expected, rtol=1e-5)
    assert row["change"] == pytest.approx(0.2)  # of both seeds, so that it has no spread
    np.testing.assert_allclose(row[["change_low", "change_high"]].tolist(), 0.2)
    assert row["relative_change"] == pytest.approx(0.2 / 0.15, rel=1e-5)
    lost = at(out / "ablation.csv", "hard", "mse_steady", 0.8)
    assert (lost["mean"], lost["min"]) == (np.inf, 0.3)
    assert np.isnan(lost[["low", "high", "std"]].tolist()).all()
    assert at(out / "ablation.csv", "default", "samples_to_walk")["mean"] == 0.75e6
    assert at(out / "ablation.csv", "hard", "samples_to_walk")["min"] == np.inf  # never


def test_a_change_is_from_the_same_seed_or_from_the_only_run():
    runs = pd.DataFrame(
        [("a", 1, 0.4, 1.0), ("a", 2, 0.4, 3.0), ("b", 2, 0.4, 5.0), ("b", 3, 0.4, 9.0)],
        columns=["variant", "seed", "speed", "cost"],
    )
    variants = [["a", "a", "", ""], ["b", "b", "", ""]]
    for some, expected in ((runs, 2.0), (runs[1:], (2.0 + 6.0) / 2)):
        change = summarise(some, variants, ["cost"]).set_index("variant")["change"]
        assert change.to_dict() == {"a": 0.0, "b": expected}


def test_tables_mark_what_differs_from_the_reference(out):
    text = (out / "ablation.md").read_text()
    assert "| as it is | 0.150 (0.100–0.200) | 0.150 (0.100–0.200) |" in text
    assert r"| hard | 0.350 (0.300–0.400) \* | ∞ (0.300–∞) |" in text
    assert "| as it is | 0.750 (0.500–1.00) |" in text  # samples until a training walks


# Cost of the gaits of two variants, and of random starts; None: IPOPT fails; negative: a residual
# is too large.
COSTS = {
    ("own", ""): {0.4: 100.0, 1.2: 204.0},
    ("coarse", ""): {0.4: 110.0, 1.2: None},
    ("own_starts", 0): {0.4: 100.001, 1.2: 200.0},
    ("own_starts", 1): {0.4: None, 1.2: 200.01},
    ("own_starts", 2): {0.4: 103.0, 1.2: 204.0},
    ("own_starts", 3): {0.4: -90.0, 1.2: 204.0},
}
GAITS = {
    "name": "gaits",
    "robot": "mine",
    "metrics": ["cost", "cost_change", "converged", "reaches_best", "joints_difference"],
    "variants": [[name, name, "", ""] for name in ("own", "coarse", "own_starts")],
    "keys": {"gaits": [[*key, speed] for key, costs in COSTS.items() for speed in costs]},
    "max_violation": 1e-6,
    "same_cost": 1e-4,
}


def solve(folder: Path, cost: float | None, nodes: int, offset: float) -> Path:
    folder.mkdir()
    worst = 1e-3 if cost is not None and cost < 0 else 1e-8
    status = "Infeasible_Problem_Detected" if cost is None else "Solve_Succeeded"
    report = {"converged": cost is not None, "status": status, "cost": abs(cost or 7.0)}
    report |= {"residuals": {"impact": worst, "friction": 0.0}, "max_violation": worst}
    report |= {"gait_transport": 0.5, "base_height": 0.7}
    report |= {"iterations": 25, "between_nodes": {"foot_line_moment": 0.5}}
    (folder / REPORT).write_text(json.dumps(report))
    if nodes:
        np.save(folder / "knee_positions.npy", np.full((2 * nodes, 10), offset))
        np.save(folder / "knee_torques.npy", np.full((2 * nodes, 10), np.sqrt(1.0 + offset)))
        np.save(folder / "roll.npy", np.zeros((2, nodes, 3)))
        np.save(folder / "step_time.npy", np.full(2, 0.4))
    return folder


@pytest.fixture(scope="module")
def gaits(tmp_path_factory) -> Path:
    folder, out = tmp_path_factory.mktemp("gaits"), tmp_path_factory.mktemp("out")
    found = []
    for (variant, _), costs in COSTS.items():
        nodes, offset = {"own": (9, 0.0), "coarse": (5, 0.1)}.get(variant, (0, 0.0))
        for cost in costs.values():
            found.append(solve(folder / str(len(found)), cost, nodes, offset))
    run(GAITS, {"gaits": found}, out, Job(out))
    return out


def test_gaits_are_compared_with_the_reference_s_where_both_converge(gaits):
    assert at(gaits / "gaits.csv", "coarse", "joints_difference", 0.4)["mean"] == pytest.approx(0.1)
    coarse = pd.read_csv(gaits / "gaits_runs.csv").set_index(["variant", "speed"]).loc["coarse"]
    for name in ("cost_change", "torque_cost_change", "joints_difference"):
        np.testing.assert_allclose(coarse[name], [0.1, np.nan])
    assert coarse["worst_constraint"].tolist() == ["impact", "impact"]
    assert coarse["status"].tolist() == ["Solve_Succeeded", "Infeasible_Problem_Detected"]


def test_starts_are_judged_by_the_library_s_criterion_and_grouped_by_cost(gaits):
    runs = pd.read_csv(gaits / "gaits_runs.csv")
    runs = runs[runs["variant"] != "coarse"]
    slow, fast = (runs[runs["speed"] == speed] for speed in (0.4, 1.2))
    assert slow["converged"].tolist() == [1, 1, 0, 1, 0]
    np.testing.assert_array_equal(slow["optimum"], [0, 0, np.nan, 1, np.nan])
    assert fast["optimum"].tolist() == [1, 0, 0, 1, 1]
    assert fast["cost_excess"].iloc[0] == pytest.approx(0.02)
    row = at(gaits / "gaits.csv", "own_starts", "reaches_best", 1.2)
    assert (row["count"], row["mean"]) == (4, 0.5)
    np.testing.assert_allclose(row[["low", "high"]].tolist(), wilson(2, 4), rtol=1e-5)


def test_of_many_variants_those_that_change_most_are_shown():
    names = [f"v{index}" for index in range(ALL + 1)]
    costs = [0.0, *(0.01 * (-1) ** i * i for i in range(1, len(names)))]
    runs = pd.DataFrame({"variant": names, "seed": "", "speed": 0.4, "cost_change": costs})
    variants = [*([name, name, "", ""] for name in names), ["x", "x", "", "not built"]]
    found = strongest(summarise(runs, variants, ["cost_change"]))
    assert found["variant"].tolist() == ["v0", *reversed(names[-SHOWN + 1 :]), "x"]
