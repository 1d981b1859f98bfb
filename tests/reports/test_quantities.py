"""How numbers are written, and that none of a table is left out."""

import math

import pandas as pd
import pytest

from slider.core.quantities import Quantity
from slider.reports.table1 import quality_tables

PLAIN, SHARE, CENTI = Quantity("a", "m"), Quantity("b", "% of time", 100), Quantity("c", "cm", 100)
OURS = {"controller": "policy", "label": "policy (ours)"}
TUNED = {"controller": "mpc_wbc_tuned", "label": "MPC + WBC, tuned"}
ROWS = [
    OURS | {"speed": 0.2, "flight": 0.0244, "clearance": 0.09, "new": 1},
    OURS | {"speed": 1.2, "flight": 1e-5, "clearance": math.nan, "new": 2},
    TUNED | {"speed": 0.2, "flight": 0, "clearance": 1, "new": 3},
]


@pytest.mark.parametrize(
    ("shown", "value", "text"),
    [
        (PLAIN, -0.0217, "-0.0217"),
        (PLAIN, 1234.5, "1234"),
        (PLAIN, 1e-10, "0"),
        (PLAIN, math.nan, "–"),
        (PLAIN, math.inf, "∞"),
        (SHARE, 0.996, "99.6"),
        (CENTI, 0.0345, "3.45"),
    ],
)
def test_numbers_as_people_read_them(shown, value, text):
    assert shown.text(value) == text


def test_intervals_and_ranges():
    assert SHARE.between(0.996, 0.99, 0.998) == "99.6 [99, 99.8]"
    assert PLAIN.ranged(0.15, 0.1, 0.2) == "0.150 (0.100–0.200)"
    assert PLAIN.ranged(0.1, 0.1, 0.1) == "0.100"


def test_no_number_of_the_quality_is_left_out():
    ours, baseline = quality_tables(pd.DataFrame(ROWS))
    assert list(ours.columns[1:]) == ["0.2", "1.2"]
    assert [[*row] for row in ours.rows] == [
        ["Flight [% of time]", "2.4", "< 0.1"],
        ["Foot clearance [cm]", "9.00", "–"],
        ["new", "1.00", "2.00"],
    ]
    assert baseline.rows[0] == ["Flight [% of time]", "0"]
