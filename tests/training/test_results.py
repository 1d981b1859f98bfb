"""A training comes back from its folder, and which of its policies was kept."""

import numpy as np
from numpy.testing import assert_array_equal

from slider.training.results import Training


def test_what_a_check_did_not_find_is_nothing(tmp_path):
    (tmp_path / "selection.csv").write_text(
        "iteration,value,success,speed_error\n5,10,0,\n10,5.3,0.5,0.1\n"
    )
    found = Training.load(tmp_path)
    assert_array_equal(found.checks["speed_error"], [np.nan, 0.1])
    assert_array_equal(found.checks["flight"], [np.nan, np.nan])
    assert found.kept == 10
    assert not found.curve


def test_the_curve_has_every_group(tmp_path):
    (tmp_path / "selection.csv").write_text("iteration,value\n1,10\n")
    (tmp_path / "learning_curve.csv").write_text("iteration,Loss/a,Reward/b\n1,0.5,2\n2,,3\n")
    curve = Training.load(tmp_path).curve
    assert_array_equal(curve["Loss/a"], [0.5, np.nan])
    assert_array_equal(curve["Reward/b"], [2, 3])


def test_of_equal_checks_the_last_was_kept():
    table = {"iteration": np.array([10.0, 20.0, 30.0]), "value": np.array([10.0, 10.0, 11.0])}
    assert Training(table, {}).kept == 20
