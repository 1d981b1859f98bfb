"""The two legs of the figure of the mapping: one hip, one ankle, one foot."""

import numpy as np
import pytest

from slider.reports.figures.mapping import LegPair, map_errors
from tests.config.composed import composed

ROBOT = composed().robot


@pytest.mark.parametrize("flexion", [0.1, 0.7, 1.4])
def test_both_legs_end_at_the_same_ankle_on_the_same_foot(flexion):
    legs = LegPair.of(ROBOT, flexion)
    pitch, ankle = legs.exact
    np.testing.assert_allclose(legs.ankle, -legs.length * np.array([np.sin(pitch), np.cos(pitch)]))
    assert pitch + ankle == pytest.approx(0.0)  # the foot is level
    assert legs.knee[0] - flexion + legs.knee[1] == pytest.approx(0.0)


def test_the_printed_leg_is_off_by_the_errors_below():
    legs = LegPair.of(ROBOT, 1.2)
    errors = map_errors(np.array([1.2]), legs.thigh, legs.shank)
    assert legs.printed[0] - legs.exact[0] == pytest.approx(errors["hip"][0])
    assert legs.printed[1] - legs.exact[1] == pytest.approx(errors["ankle"][0])
