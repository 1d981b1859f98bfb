"""Time series of commands from their segments."""

import numpy as np
import pytest

from slider.config.evaluation import CaseConfig, Segment
from slider.evaluation.profile import commands, windows

PERIOD = 0.02


def case() -> CaseConfig:
    segments = [
        Segment("stand", 0.0, 0.0, 0.0, 0.0),
        Segment("turn", 1.0, 0.4, 0.0, 0.3),
        Segment("side", 2.0, 0.0, -0.1, 0.0),
    ]
    return CaseConfig("tour", segments)


def test_steps_change_at_their_times():
    values = commands(case(), 0.0, 3.0, PERIOD)
    assert values.shape == (150, 3)
    expected = np.repeat([[0, 0, 0], [0.4, 0, 0.3], [0, -0.1, 0]], 50, axis=0)
    np.testing.assert_array_equal(values, expected)


def test_ramps_lead_from_one_command_to_the_next():
    values = commands(case(), 0.4, 3.0, PERIOD)
    np.testing.assert_allclose(values[50:71, 0], 0.4 * np.arange(21) / 20, atol=1e-12)
    np.testing.assert_allclose(values[110], [0.2, -0.05, 0.15], atol=1e-12)
    np.testing.assert_array_equal(values[71:100], np.tile([0.4, 0.0, 0.3], (29, 1)))
    assert not values[:50].any()


def test_windows_leave_the_start_of_each_segment_out():
    found = windows(case(), 0.5, 3.0, PERIOD)
    assert found == [slice(25, 50), slice(75, 100), slice(125, 150)]


@pytest.mark.parametrize(("time", "step"), [(0.02, 1), (0.025, 1), (0.035, 2), (0.58, 29)])
def test_a_segment_begins_at_the_nearest_control_step(time, step):
    """Command and window alike."""
    stand, go = Segment("stand", 0.0, 0.0, 0.0, 0.0), Segment("go", time, 0.4, 0.0, 0.0)
    short = CaseConfig("short", [stand, go])
    values = commands(short, 0.0, 1.0, PERIOD)[:, 0]
    np.testing.assert_array_equal(values, np.where(np.arange(50) < step, 0.0, 0.4))
    assert windows(short, 0.0, 1.0, PERIOD) == [slice(0, step), slice(step, 50)]
