"""An evaluation comes back from its folder as it was, and its numbers are those by hand."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from slider.env.metrics import ERRORS, QUALITY, TRACKING
from slider.evaluation import results, segments
from slider.evaluation.results import Evaluation, wilson
from tests.evaluation.test_segments import case, protocol, recording


def random_robots() -> pd.DataFrame:
    rng = np.random.default_rng(0)
    survived = np.array([True, True, False, True, False, True])
    names = (*TRACKING[1:4], *ERRORS, *QUALITY)
    columns = {
        name: np.where(survived, 10.0**k * rng.uniform(size=6), np.nan)
        for k, name in enumerate(names, start=-4)
    }
    columns |= {"survived": survived, "tracked": survived & (np.arange(6) > 2)}
    return results.robots_frame(2, 3, columns | {"diverged": ~survived})


def make_robots(survived: list[list[int]], error: list[list[float]]) -> pd.DataFrame:
    """Trials (rows) of robots (columns); steady errors are a tenth, the first robot tracks."""
    alive = np.array(survived, dtype=bool)
    errors = np.where(alive, np.array(error, dtype=float), np.nan).ravel()
    tracked = alive & (np.arange(alive.shape[1]) == 0)
    columns = {name: errors * k for names in (QUALITY, ERRORS) for k, name in enumerate(names)}
    columns |= {"survived": alive.ravel(), "squared_error": errors, "tracked": tracked.ravel()}
    columns |= {"squared_error_steady": errors / 10, "mean_velocity": errors + 1}
    return results.robots_frame(
        len(alive), alive.shape[1], columns | {"diverged": np.zeros(alive.size, bool)}
    )


def write_evaluation(folder: Path, command: float, found: pd.DataFrame) -> Path:
    folder.mkdir(parents=True)
    Evaluation("policy", command, found).save(folder)
    return folder


def changing() -> Evaluation:
    """In a case with three segments."""
    rollout = recording()
    found = segments.measure(rollout, protocol(), case())
    traces = segments.traces(rollout, protocol())
    velocity = np.ones((5, 2), dtype=np.float32)
    return Evaluation("policy", None, random_robots(), velocity, "tour", found, traces)


@pytest.mark.parametrize(
    "written", [replace(changing(), speed=0.2, case="", segments=None, traces=None), changing()]
)
def test_save_then_load(tmp_path, written):
    written.save(tmp_path)
    back = Evaluation.load(tmp_path)
    assert tuple(back.robots) == results.COLUMNS == tuple(written.robots)
    pd.testing.assert_frame_equal(back.robots, written.robots, rtol=1e-8, atol=1e-12)
    assert (back.segments is None) == (written.segments is None)
    if back.segments is not None:
        pd.testing.assert_frame_equal(back.segments, written.segments, rtol=1e-8, atol=1e-12)
    assert (back.controller, back.speed, back.case) == ("policy", written.speed, written.case)
    np.testing.assert_array_equal(back.velocity, written.velocity)
    np.testing.assert_equal(back.traces, written.traces)
    again = tmp_path / "again"
    again.mkdir()
    back.save(again)
    for path in again.iterdir():
        assert path.read_bytes() == (tmp_path / path.name).read_bytes(), path.name
    about = json.loads((tmp_path / "metadata.json").read_text())
    assert ("case" in about) == bool(written.case)


def test_numbers_by_hand():
    """Spread: standard deviation over trials of their means, 0.75 and 0.5; 2 and 6."""
    found = make_robots([[1, 1, 0, 1], [1, 0, 0, 1]], [[1, 2, 9, 3], [4, 9, 9, 8]])
    low, high = wilson(5, 8)  # robots, not trials
    assert results.success(found) == {
        "success_rate": pytest.approx(5 / 8),
        "success_rate_std": pytest.approx(0.25 / np.sqrt(2)),
        "success_low": low,
        "success_high": high,
    }
    assert results.accuracy(found) == {
        "tracking_rate": pytest.approx(2 / 8),
        "tracking_rate_std": 0.0,
        "mse": pytest.approx((1 + 2 + 3 + 4 + 8) / 5),
        "mse_std": pytest.approx(4 / np.sqrt(2)),
        "mse_steady": pytest.approx(0.36),
        "mse_steady_std": pytest.approx(0.4 / np.sqrt(2)),
    }
    assert results.means(found, ["mean_velocity"])["mean_velocity"] == pytest.approx(4.6)


def test_none_survives():
    found = make_robots([[0, 0], [0, 0]], [[1, 1], [1, 1]])
    success, rates = results.success(found), results.accuracy(found)
    assert success["success_rate"] == success["success_rate_std"] == 0.0
    assert rates["mse"] == rates["mse_steady"] == float("inf")
    assert np.isnan(
        [rates["mse_std"], rates["mse_steady_std"], results.quality(found)["slip"]]
    ).all()


@pytest.mark.parametrize(
    ("successes", "count", "low", "high"),
    [
        (81, 263, 0.2553, 0.3662),  # Newcombe 1998, Statistics in Medicine 17, table I, method 3
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0, 0.1611),
        (20, 20, 0.8389, 1.0),
        (1, 29, 0.0061, 0.1718),
    ],
)
def test_published_values(successes, count, low, high):
    assert wilson(successes, count) == pytest.approx((low, high), abs=5e-5)
