"""What the learning curves show."""

import numpy as np
from numpy.testing import assert_array_equal

from slider.reports.sections import learning


def test_checks_without_survivors_have_no_speed_error():
    table = {
        "success": np.array([0.0, 0.5]),
        "speed_error": np.array([1000.0, 0.1]),
        "value": np.array([1010.0, 5.3]),
    }
    assert_array_equal(learning._known(table, "speed_error"), [np.nan, 0.1])
    assert_array_equal(learning._known(table, "value"), table["value"])


def test_of_equal_checks_the_last_was_kept():
    table = {"iteration": np.array([10.0, 20.0, 30.0]), "value": np.array([10.0, 10.0, 11.0])}
    assert learning._kept(table) == 20
