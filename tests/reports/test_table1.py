"""The table's numbers from records whose answers are known; the paper's beside them."""

import math

import numpy as np
import pandas as pd
import pytest

from slider.core import tables
from slider.core.job import Job
from slider.env.metrics import QUALITY
from slider.evaluation.results import quality
from slider.library.blend import gait_statistics
from slider.library.reader import GaitLibrary
from slider.reports import table1
from slider.reports.table1 import compare, comparisons
from tests.evaluation.test_results import make_robots, write_evaluation
from tests.library.gaits import write_store

SECTION = {"labels": {"policy": "policy (ours)"}, "robot": "slider"}


def test_some_of_the_papers_numbers():
    rows = {(r["controller"], r["speed"]): r for r in table1.paper_rows().to_dict("records")}
    assert len(rows) == 14
    assert rows["guided_drl", 3.0].items() >= {"success_rate": 0.731, "mse": 1.6}.items()
    assert rows["mpc_wbc", 1.0]["mse"] == float("inf")


def run_stage(folder, found, section=SECTION, **inputs):
    out = folder / "out"
    out.mkdir()
    inputs["evaluations"] = [write_evaluation(folder / str(v), v, one) for v, one in found.items()]
    return table1.run(section, inputs, out, Job(folder)), out


def test_the_stage(tmp_path):
    walks = make_robots([[1, 1], [1, 0]], [[0.5, 0.25], [0.125, 1]])
    falls = make_robots([[0, 0], [0, 0]], [[1, 1], [1, 1]])
    summary, out = run_stage(tmp_path, {0.2: walks, 3.0: falls})
    assert summary == {"rows": 2}
    assert "The paper states one MSE" in (out / "table1.md").read_text()
    assert "# How it walks" in (out / "gait_quality.md").read_text()
    rows = tables.read(out / "table1.csv")
    assert [*rows] == [*table1.COLUMNS]
    assert rows["source"].value_counts().to_dict() == {"measured": 2, "paper": 14}
    assert rows[["speed", "mse"]][:2].to_numpy().tolist() == [[0.2, 0.291667], [3, math.inf]]
    quality = tables.read(out / "gait_quality.csv")
    assert quality["speed"].tolist() == [0.2, 3]
    assert quality["mean_velocity"][0] == pytest.approx(1 + 0.875 / 3, rel=1e-5)
    assert quality["double_support"][0] == pytest.approx(0.875 / 3, rel=1e-5)
    assert quality.loc[1, [*QUALITY]].isna().all()
    assert quality["reference_velocity_variance"].isna().all(), "there is no library"


def test_the_paper_has_no_rows_of_another_robot(tmp_path):
    walks = make_robots([[1, 1]], [[0.5, 0.25]])
    _, out = run_stage(tmp_path, {0.2: walks}, SECTION | {"robot": "BRUCE"})
    assert tables.read(out / "table1.csv")["source"].tolist() == ["measured"]
    text = (out / "table1.md").read_text()
    assert "Robot: BRUCE" in text
    assert "paper" not in text


def test_extremes_are_those_of_all_robots_that_survive():
    """Three robots, the last of which fell."""
    table = make_robots([[1, 1, 0]], [[1, 2, 9]])
    values = {"heading": (0.1, 0.3), "peak_effort": (0.5, 0.9), "peak_speed": (0.8, 0.2)}
    values |= {"slip": (0.02, 0.04), "leg_distance": (0.05, -0.01)}
    values |= {"legs_touch": (0.0, 0.2), "legs_cross": (0.1, 0.3)}
    columns = {name: np.array([*pair, np.nan]) for name, pair in values.items()}
    row = quality(table.assign(**columns))
    expected = {"heading": 0.2, "heading_worst": 0.3, "peak_effort": 0.9, "peak_speed": 0.8}
    expected |= {"slip": 0.03, "leg_distance": -0.01, "legs_touch": 0.1, "robots_touch": 0.5}
    expected |= {"legs_cross": 0.2, "robots_cross": 1.0}
    assert {name: row[name] for name in expected} == pytest.approx(expected)
    assert np.isnan([*quality(make_robots([[0]], [[1]])).values()]).all()


def test_numbers_of_the_gait_stand_beside_those_of_every_controller(tmp_path):
    store = write_store(tmp_path / "gaits", [(0.0, 0.0), (1.0, 0.0)])
    found = dict.fromkeys((0.2, 0.4, 3.0), make_robots([[1, 1]], [[1, 2]]))
    _, out = run_stage(tmp_path, found, library=[store.parent])
    quality, library = tables.read(out / "gait_quality.csv"), GaitLibrary.load(store)
    for name in ("velocity_variance", "touchdown_rate"):
        beside = quality.columns[quality.columns.get_loc(name) + 1]
        assert beside == f"reference_{name}"
        expected = [getattr(gait_statistics(library, speed), name) for speed in (0.2, 0.4)]
        np.testing.assert_allclose(quality[beside], [*expected, np.nan], rtol=1e-5)  # up to 1 m/s


SUCCESS, STEADY, WHOLE, TRACKING = table1.METRICS


def row_of(controller, command, source="measured", **values):
    names = ("success_rate", "mse", "mse_steady", "tracking_rate")
    names = [*names, *(f"{name}_std" for name in names), "success_low", "success_high"]
    about = {"controller": controller, "label": f"{controller} of {source}", "source": source}
    return dict.fromkeys(names, math.nan) | about | {"speed": command} | values


RECORDS = [
    row_of("policy", 1.0, success_rate=1, success_rate_std=0, mse=0.0246, mse_steady=0.00271),
    row_of("mpc_wbc_tuned", 1.0, success_rate=0.5, mse=0.5, mse_steady=0.4),
    row_of("policy", 0.2, success_rate=1, mse=0.001, mse_steady=0.0005),
    row_of("guided_drl", 0.2, "paper", success_rate=1, mse=0.0317),
    row_of("guided_drl", 1.0, "paper", success_rate=1, mse=0.0221),
    row_of("mpc_wbc", 1.0, "paper", success_rate=0, mse=math.inf),
]
ROWS = pd.DataFrame(RECORDS)


def test_commands_are_sorted_and_all_who_share_the_best_value_are_marked():
    table = compare(ROWS, SUCCESS)
    assert [row[0] for row in table.rows] == ["0.2", "1.0"]
    assert table.columns[1] == "policy of measured"
    assert table.rows[0][2] == "–"  # not evaluated at 0.2 m/s
    assert [cell.startswith("**") for cell in table.rows[1][1:]] == [True, False, True, False]


def test_an_error_of_few_survivors_is_not_the_best():
    for success, wins in ((0.001, False), (0.995, True)):
        rows = [*RECORDS, row_of("other", 1.0, success_rate=success, mse=1e-6)]
        best = [cell.startswith("**") for cell in compare(pd.DataFrame(rows), WHOLE).rows[1][1:]]
        assert best == [False, False, not wins, False, wins]


def test_a_metric_that_the_paper_does_not_have_is_ours_alone():
    rows = [row_of("policy", 1.0, tracking_rate=0.9), *RECORDS[3:]]
    assert compare(pd.DataFrame(rows), TRACKING).columns[1:] == ["policy of measured"]


def test_nobody_is_best_where_nobody_survives():
    rows = pd.DataFrame([row_of("policy", 1.0, mse=math.inf), RECORDS[-1]])
    assert not any("**" in cell for cell in compare(rows, WHOLE).rows[0])


@pytest.mark.parametrize(
    ("metric", "values", "text"),
    [
        (SUCCESS, (0.996, math.nan, 0.98981, 0.99844), "99.6 % [99.0, 99.8]"),
        (STEADY, (0.000461344, 1.9e-5), "0.000461 ± 0.000019"),
        (WHOLE, (math.inf,), "∞"),
    ],
)
def test_prints_three_digits_spread_and_interval(metric, values, text):
    names = metric, f"{metric}_std", "success_low", "success_high"
    row = row_of("policy", 1.0, **dict(zip(names, values, strict=False)))
    assert compare(pd.DataFrame([row]), metric).rows[0][1] == text


def test_latex_is_escaped_and_balanced():
    text = "".join(table.latex for table in comparisons(ROWS))
    assert "0.0246 & 0.500 & \\textbf{0.0221} & $\\infty$ \\\\" in text
    assert text.count("\\begin{tabular}") == text.count("\\end{tabular}") == len(table1.METRICS)
    assert not any(character in text for character in "±∞²–")
