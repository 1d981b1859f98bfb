"""Gaits whose phase is the hip pass each place once."""

import numpy as np
import pytest

from slider.core.arrays import take
from slider.core.errors import UserError
from slider.hzd.constraints import phase_of
from slider.hzd.plans import plans
from tests.hzd.sample import CLOCK, HIP, library, loop, settings, steps


def test_a_hip_that_turns_back_is_named(monkeypatch):
    config, constrained = settings(), loop().model.constrained

    def turned_back(*arguments):
        rows, bias, slope, bend = constrained(*arguments)
        return rows, bias, -slope, bend

    monkeypatch.setattr(loop().model, "constrained", turned_back)
    plans(library(), np.array([CLOCK]), loop().model, config)
    with pytest.raises(UserError, match=r"turns back in the gait \(0\.6, 0\.1\) m/s"):
        plans(library(), np.array([CLOCK, HIP]), loop().model, config)


def test_a_robot_that_is_lost_has_no_place_and_does_not_disturb_the_others():
    table = take(steps()[0].hip, np.array([HIP, HIP]))
    found = phase_of(table, np.array([np.nan, table.at(np.full(2, 0.3))[0][0, 0]]))
    assert np.isnan(found[0])
    assert found[1] == pytest.approx(0.3, abs=1e-9)
