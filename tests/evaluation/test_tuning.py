"""The search for a controller's settings: its score, its trials, and going on after a kill."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from slider.core.job import Job
from slider.evaluation import tuning
from slider.reports import tuning as report
from tests.evaluation.test_stage import baseline

BOUNDS = {"step.apex": (0.05, 0.09), "planner.steps": (4.0, 5.0)}
SPACE = {name: {"lower": a, "upper": b, "log": False} for name, (a, b) in BOUNDS.items()}


def section(trials: int = 3, seed: int = 1) -> dict:
    short = {"duration": 1.0, "warm_up": 0.4, "trials": 1, "robots": 2, "seed": 1000}
    search = {"trials": trials, "sampler_seed": seed, "finalists": 2, "finalist_robots": 3}
    whole = baseline(**short)
    whole["evaluation"].pop("controllers", None)  # as the pipeline's section
    return whole | search | {"speeds": [0.2, 0.4], "space": SPACE}


def search(folder, name: str, trials: int = 3, seed: int = 1) -> pd.DataFrame:
    for made in (name, "work"):
        (folder / made).mkdir(parents=True, exist_ok=True)
    summary = tuning.run(section(trials, seed), {}, folder / name, Job(folder / "work"))
    table = pd.read_csv(folder / name / tuning.CSV)
    searched, finalists = (table.query(f"finalist == {number}") for number in (0, 1))
    best = finalists.sort_values("score", kind="stable").iloc[0]
    assert summary == {"best": best["trial"], "score": pytest.approx(best["score"], abs=1e-4)}
    drawn = searched[1:].sort_values("score", kind="stable")["trial"][:2]
    assert list(finalists["trial"]) == [0, *drawn], "the present one and the best of the others"
    return searched


def test_a_share_of_falls_adds_to_the_error():
    survived = np.array([True] * 20 + [False] + [True] * 19 + [False] * 20)
    errors = np.where(survived, 0.02, np.nan)
    follows = survived & (np.arange(60) != 0)
    tracked = {"survived": survived, "tracked": follows, "squared_error_steady": errors}
    columns, score = tuning.scored(tracked, [1.0, 2.0, 3.0])
    rates = {"success_rate_1": 1.0, "success_rate_2": 0.95, "success_rate_3": 0.0}
    rates |= {"tracking_rate_1": 0.95, "tracking_rate_2": 0.95, "tracking_rate_3": 0.0}
    assert columns == pytest.approx(rates | {"error_1": 0.02, "error_2": 0.02, "error_3": 9.0})
    assert score == pytest.approx((np.log10(0.02) + np.log10(0.005 + 0.005) + np.log10(1.1)) / 3)


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> tuple[Path, pd.DataFrame]:
    """Folder of a search that nothing interrupts, and its trials."""
    folder = tmp_path_factory.mktemp("whole")
    return folder / "out", search(folder, "out")


def test_the_first_trial_is_the_present_one(whole):
    _, table = whole
    assert list(table["trial"]) == [0, 1, 2]
    assert (table["step.apex"][0], table["planner.steps"][0]) == (0.0669, 2)
    assert len(set(table["step.apex"])) == 3
    assert table["step.apex"].between(0.05, 0.09).all()
    assert table["planner.steps"].isin([2, 3, 4, 5]).all(), "whole, and the present one among them"


def test_a_killed_search_goes_on_to_the_same_trials(whole, tmp_path, monkeypatch):
    measure, calls = tuning._measure, []

    def killed(*arguments):
        calls.append(arguments)
        if len(calls) in (1, 4, 7):
            raise KeyboardInterrupt
        return measure(*arguments)

    monkeypatch.setattr(tuning, "_measure", killed)
    for _ in range(3):  # in the first trial, in the third and in the second finalist
        with pytest.raises(KeyboardInterrupt):
            search(tmp_path, "killed")
    table = search(tmp_path, "out")
    pd.testing.assert_frame_equal(table, whole[1], check_exact=True)
    assert len(calls) == 3 + 3 + 3, "what was measured is not measured again"
    found, expected = ((out / tuning.CSV).read_bytes() for out in (tmp_path / "out", whole[0]))
    assert found == expected


def test_the_search_finds_a_minimum(tmp_path, monkeypatch):
    """After ten random trials the Gaussian process comes close, in the same way after a kill."""
    killed = iter([False] * 12 + [True] + [False] * 99)

    def bowl(*arguments):
        if next(killed):
            raise KeyboardInterrupt
        return {}, (arguments[-1]["step.apex"] - 0.0778) ** 2

    monkeypatch.setattr(tuning, "_measure", bowl)
    with pytest.raises(KeyboardInterrupt):
        search(tmp_path / "a", "out", trials=14)
    one, two = (search(tmp_path / name, "out", trials=14) for name in "ab")
    pd.testing.assert_frame_equal(one, two)
    assert abs(one["step.apex"][-2:] - 0.0778).max() < 0.001


def test_the_table_has_present_and_best_values(whole, tmp_path):
    names = {"mpc_wbc_tuned": "MPC + WBC, tuned"}
    (tmp_path / "out").mkdir()
    table = {"labels": names, "spaces": {"mpc_wbc_tuned": SPACE}, "robot": "slider"}
    searches = {"searches": [whole[0]]}
    summary = report.run(table, searches, tmp_path / "out", Job(tmp_path / "work"))
    assert summary["trials"] == 3 + 3
    text = (tmp_path / "out" / "baseline_tuning.md").read_text()
    assert "| step.apex | 0.05 to 0.09 | 0.0669 |" in text
    assert "| Success rate [%], present | 100 | 100 |" in text
    rows = pd.read_csv(tmp_path / "out" / "baseline_tuning.csv")
    assert list(rows["controller"]) == 6 * ["mpc_wbc_tuned"]
