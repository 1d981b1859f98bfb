"""The ablation's tables from evaluations and checks whose answers are known."""

import csv
from pathlib import Path

import numpy as np
import pytest

from slider.core.job import Job
from slider.library.blend import gait_numbers
from slider.library.reader import GaitLibrary
from slider.reports.ablation import check_rows, run, spread
from slider.reports.quantities import Quantity
from slider.training.results import Training
from tests.evaluation.test_results import make_robots, write_evaluation
from tests.library.gaits import write_store

COMMANDS = [0.2, 0.8]
SECTION = {
    "name": "ablation",
    "commands": COMMANDS,
    "variants": {
        "default": {"label": "as it is", "overrides": []},
        "hard": {"label": "hard", "overrides": ["gait.cost=torque", "env=paper"]},
    },
    "runs": [
        {"variant": "default", "seed": 1, "batch": 100_000},
        {"variant": "default", "seed": 2, "batch": 100_000},
        {"variant": "hard", "seed": 1, "batch": 200_000},
        {"variant": "hard", "seed": 2, "batch": 200_000},
    ],
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
def inputs(tmp_path_factory) -> dict[str, list[Path]]:
    folder = tmp_path_factory.mktemp("ablation")
    checks = ([0.0, 0.96], [0.97, 1.0], [0.0, 0.5], [0.0, 0.0])
    walking = [write_checks(folder / f"walking{i}", found) for i, found in enumerate(checks)]
    evaluations = []
    for index in range(len(walking)):
        for command in COMMANDS:
            alive = [[0, 0]] if (index, command) == (3, 0.8) else [[1, 1]]
            errors = make_robots(alive, [[1.0 + index, 1.0 + index]])
            evaluations.append(write_evaluation(folder / f"e{len(evaluations)}", command, errors))
    library = write_store(folder / "gaits", [(0.0, 0.0), (1.0, 0.0)]).parent
    return {"walking": walking, "evaluations": evaluations, "library": [library]}


@pytest.fixture(scope="module")
def out(inputs, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("out")
    assert run(SECTION, inputs, folder, Job(folder)) == {"runs": 4, "variants": 2}
    return folder


def rows(path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(path.read_text().splitlines()))


def test_one_row_per_run_and_command(out, inputs):
    found = rows(out / "ablation.csv")
    keys = [(row["variant"], row["seed"], row["command_velocity"]) for row in found]
    assert keys == [
        (item["variant"], str(item["seed"]), f"{command:g}")
        for item in SECTION["runs"]
        for command in COMMANDS
    ]
    assert [float(row["mse_steady"]) for row in found] == pytest.approx(
        [0.1, 0.1, 0.2, 0.2, 0.3, 0.3, 0.4, np.inf]
    )
    assert (found[-1]["success_rate"], found[-1]["alternation"]) == ("0", "")
    library = GaitLibrary.load(inputs["library"][0] / "library.zarr")
    for name in ("velocity_variance", "touchdown_rate"):
        gaits = [f"{getattr(gait_numbers(library, v), name):.6g}" for v in COMMANDS]
        assert [row[f"reference_{name}"] for row in found] == 4 * gaits


def test_curves_are_over_samples_and_have_no_error_without_survivors(out, inputs):
    found = rows(out / "ablation_curves.csv")
    assert [float(row["samples"]) for row in found[4:6]] == [1e6, 2e6]
    assert [(row["success"], row["speed_error"]) for row in found[:2]] == [
        ("0", ""),
        ("0.96", "0.2"),
    ]
    checks = list(check_rows(Training.load(inputs["walking"][2]), 10))
    assert [check["samples"] for check in checks] == [50, 100]
    assert np.isnan([check["flight"] for check in checks]).tolist() == [True, False]


def test_the_page_says_what_differs_and_how_seeds_spread(out):
    text = (out / "ablation.md").read_text()
    assert "| hard | never | `gait.cost=torque` `env=paper` |" in text
    assert "| as it is | 0.750 (0.500–1.00) | none |" in text
    assert "| as it is | 0.150 (0.100–0.200) | 0.150 (0.100–0.200) |" in text
    assert "| hard | 100 | 50 (0–100) |" in text
    assert "| hard | 0.350 (0.300–0.400) | ∞ (0.300–∞) |" in text


def test_same_input_same_bytes(out, inputs, tmp_path):
    run(SECTION, inputs, tmp_path, Job(tmp_path))
    names = {path.name for path in out.iterdir()}
    assert names == {
        *("ablation.csv", "ablation_curves.csv", "ablation.md", "ablation.svg", "ablation.png")
    }
    for name in names:
        assert (tmp_path / name).read_bytes() == (out / name).read_bytes(), name


def test_what_is_unknown_does_not_count():
    found = spread(Quantity("any"), [1.0, float("nan"), 4.0])
    assert (found.text, found.key) == ("2.50 (1.00–4.00)", 2.5)
    assert spread(Quantity("any"), [float("nan")]).text == "–"
