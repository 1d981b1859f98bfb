"""A training comes back from its folder, and which of its policies was kept."""

import numpy as np
from numpy.testing import assert_array_equal

from slider.training.results import Training


def test_checks_without_survivors_lack_columns_and_the_last_best_was_kept(tmp_path):
    (tmp_path / "selection.csv").write_text(
        "iteration,value,success,speed_error\n5,5.3,0,\n10,5.3,0.5,0.1\n15,6,0.5,0.1\n"
    )
    found = Training.load(tmp_path)
    assert_array_equal(found.checks["speed_error"], [np.nan, 0.1, 0.1])
    assert_array_equal(found.checks["flight"], [np.nan] * 3)
    assert found.kept == 10
    assert found.curve.empty
    (tmp_path / "learning_curve.csv").write_text("iteration,Loss/a,Reward/b\n1,0.5,2\n2,,3\n")
    assert_array_equal(Training.load(tmp_path).curve["Loss/a"], [0.5, np.nan])
