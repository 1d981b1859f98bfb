"""Per-robot records come back from their file as they were."""

from dataclasses import fields

import numpy as np
import pytest

from slider.core.errors import UserError
from slider.env.metrics import GaitQuality, Tracking
from slider.evaluation import records


def make_records(rng: np.random.Generator) -> records.Records:
    survived = np.array([True, True, False, True, False, True])
    exponents = range(-4, len(fields(GaitQuality)) - 1)
    numbers = [np.where(survived, 10.0**k * rng.uniform(size=6), np.nan) for k in exponents]
    tracked = Tracking(survived, *numbers[:3], tracked=survived & (np.arange(6) > 2))
    quality = GaitQuality(*numbers[3:])
    return records.build(2, 3, tracked, quality, ~survived)


def test_write_then_read(tmp_path):
    table = make_records(np.random.default_rng(0))
    path = tmp_path / records.FILE
    records.write(table, path)
    back = records.read(path)
    assert tuple(back) == records.COLUMNS == tuple(table)
    for name in records.COLUMNS:
        np.testing.assert_allclose(back[name], table[name], rtol=1e-8, err_msg=name)
    for name in ("survived", "tracked", "diverged"):
        assert back[name].dtype == bool
        np.testing.assert_array_equal(back[name], table[name])
    records.write(back, tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_bytes() == path.read_bytes()


def test_robots_of_a_trial_are_neighbours():
    table = make_records(np.random.default_rng(0))
    np.testing.assert_array_equal(table["trial"], [0, 0, 0, 1, 1, 1])
    np.testing.assert_array_equal(table["robot"], [0, 1, 2, 0, 1, 2])


def test_other_columns_are_one_line(tmp_path):
    path = tmp_path / records.FILE
    path.write_text("trial,robot\n0,1\n")
    with pytest.raises(UserError, match=r"expected the columns trial,.*, found trial,robot"):
        records.read(path)
