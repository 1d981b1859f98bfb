"""One gait for other programs."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from slider.library.export import write_csv
from slider.library.reader import GaitLibrary
from tests.env.synthetic import CHANNELS, JOINTS
from tests.library.gaits import library as make_library
from tests.library.gaits import value


@pytest.fixture(scope="module")
def library(tmp_path_factory) -> GaitLibrary:
    return make_library(tmp_path_factory.mktemp("export"), [(0.0, 0.0), (0.5, 0.1)])


def test_csv_has_a_row_per_sample_and_units_in_its_header(library, tmp_path: Path):
    write_csv(library, 1, tmp_path / "gait.csv")
    table, samples = pd.read_csv(tmp_path / "gait.csv"), value("samples", 0.5, 0.1)
    assert table.shape == (42, 2 + 26 + 13 + 12 + 6)
    expected = {
        "left_slide.position [m]": samples[:, CHANNELS.index("left_slide.position")],
        "right_ankle.velocity [rad/s]": samples[:, CHANNELS.index("right_ankle.velocity")],
        "left_slide.effort [N]": value("efforts", 0.5, 0.1)[:, JOINTS.index("left_slide")],
        "base_motion.z [m]": value("base", 0.5, 0.1)[:, 2],
    }
    for column, values in expected.items():
        np.testing.assert_allclose(table[column], values, rtol=1e-9)
    assert set(table["stance"]) <= {"left", "right"}
