"""The figures of stability show what its table and basins hold, and repeat themselves."""

from pathlib import Path

import numpy as np
import pytest

from slider.core.job import Job
from slider.hzd.summary import CSV, QUANTITIES, write_csv
from slider.reports.figures import STABILITY_FILES
from slider.reports.figures.stability import Basin, run
from slider.robot.names import COMMAND
from tests.library.gaits import write_store

GAITS = [(0.0, 0.0, 0.0), (0.5, 0.0, 0.0), (0.5, 0.1, 0.0)]


@pytest.fixture(scope="module")
def inputs(tmp_path_factory) -> dict[str, list[Path]]:
    folder = tmp_path_factory.mktemp("stability")
    store = write_store(folder / "library", GAITS, []).parent
    values = dict.fromkeys(QUANTITIES, 1.5)
    rows = [dict(zip(COMMAND, gait, strict=True)) | values for gait in GAITS[:2]]
    rows.append(dict(zip(COMMAND, GAITS[2], strict=True)))  # without a limit cycle
    write_csv(folder / CSV, rows)
    basin = folder / "basin"
    basin.mkdir()
    angle = np.linspace(0, 2 * np.pi, 42)
    arrays = {
        "command": np.array([0.5, 0.1, 0.0]),
        "roll": np.array([-0.1, 0.0, 0.1]),
        "roll_rate": np.array([-1.0, 1.0]),
        "without": np.full((3, 2), -1),
        "with": np.arange(6).reshape(3, 2),
        "walk_without": np.zeros((0, 2)),
        "walk_with": np.stack([2 * np.cos(angle), np.sin(angle)], axis=1),
        "cycle": np.stack([np.cos(angle), np.sin(angle)], axis=1),
    }
    for name, array in arrays.items():
        np.save(basin / f"{name}.npy", array)
    return {"library": [store], "stability": [folder], "basins": [basin]}


def drawn(inputs: dict[str, list[Path]], out: Path) -> dict[str, bytes]:
    out.mkdir()
    run({}, inputs, out, Job(out))
    return {path.name: path.read_bytes() for path in out.iterdir()}


def test_draws_and_repeats_itself(inputs, tmp_path):
    first = drawn(inputs, tmp_path / "one")
    assert first == drawn(inputs, tmp_path / "two")
    assert set(first) == set(STABILITY_FILES)


def test_a_library_without_gaits_of_the_basins_has_empty_pictures(inputs, tmp_path):
    without = {name: inputs[name] for name in ("library", "stability")}
    assert set(drawn(without, tmp_path / "none")) == set(STABILITY_FILES)


def test_a_basin_is_read_as_it_was_written(inputs):
    found = Basin.load(inputs["basins"][0])
    assert found.title == "(0.5, 0.1) m/s"
    assert found.steps.shape == (2, 3, 2)
    assert found.steps[1, 2, 1] == 5
    assert [len(walked) for walked in found.walks] == [0, 42]
