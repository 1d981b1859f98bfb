"""What is written on a film's pictures."""

import numpy as np

from slider.reports.film import annotate


def test_the_facts_are_within_the_picture():
    facts = "command 3.00 m/s   actual 2.60 m/s   t = 10.0 s"
    image = annotate(np.zeros((300, 480, 3), np.uint8), "MPC + WBC, tuned", facts, False)
    row = np.asarray(image)[-24:-8].max(axis=(0, 2)) > 128  # columns with ink
    ink = np.flatnonzero(row)
    assert ink[-1] < 470
