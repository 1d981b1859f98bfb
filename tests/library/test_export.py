"""One gait for other programs."""

import csv
from pathlib import Path

import numpy as np
import pytest

from slider.library.export import write_csv, write_npz
from slider.library.reader import ARRAYS, GaitLibrary
from slider.robot.names import CHANNELS, JOINTS
from tests.library.gaits import library as make_library
from tests.library.gaits import value


@pytest.fixture(scope="module")
def library(tmp_path_factory) -> GaitLibrary:
    return make_library(tmp_path_factory.mktemp("export"), [(0.0, 0.0), (0.5, 0.1)])


def test_csv_has_a_row_per_sample_and_units_in_its_header(library, tmp_path: Path):
    write_csv(library, 1, tmp_path / "gait.csv")
    with (tmp_path / "gait.csv").open() as file:
        rows = list(csv.DictReader(file))
    samples = value("samples", 0.5, 0.1)
    assert len(rows) == 42
    assert len(rows[0]) == 2 + 26 + 13 + 12 + 6
    for name, unit in (("left_slide.position", "m"), ("right_ankle.velocity", "rad/s")):
        found = [float(row[f"{name} [{unit}]"]) for row in rows]
        np.testing.assert_allclose(found, samples[:, CHANNELS.index(name)], rtol=1e-9)
    forces = [float(row["left_slide.effort [N]"]) for row in rows]
    expected = value("efforts", 0.5, 0.1)[:, JOINTS.index("left_slide")]
    np.testing.assert_allclose(forces, expected, rtol=1e-9)
    heights = [float(row["base_motion.z [m]"]) for row in rows]
    np.testing.assert_allclose(heights, value("base", 0.5, 0.1)[:, 2], rtol=1e-9)
    assert {row["stance"] for row in rows} <= {"left", "right"}


def test_npz_has_every_array_and_the_names_of_its_columns(library, tmp_path: Path):
    write_npz(library, 1, tmp_path / "gait.out")
    with np.load(tmp_path / "gait.out") as found:
        for name in ARRAYS:
            np.testing.assert_array_equal(found[name], library.arrays[name][1])
        assert found["channel_names"].tolist() == list(CHANNELS)
        assert found["constraint_names"].tolist() == ["impact", "torso"]
        assert found["velocities"].tolist() == [0.5, 0.1, 0.0]
        assert str(found["status"]) == "Solve_Succeeded"


def test_the_same_gait_gives_the_same_bytes(library, tmp_path: Path):
    for name in ("one", "two"):
        write_csv(library, 0, tmp_path / f"{name}.csv")
        write_npz(library, 0, tmp_path / f"{name}.npz")
    for suffix in ("csv", "npz"):
        first, second = (tmp_path / f"{name}.{suffix}" for name in ("one", "two"))
        assert first.read_bytes() == second.read_bytes()
