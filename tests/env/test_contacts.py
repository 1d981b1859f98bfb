"""Touchdowns of feet that bounce, and which ends of a foot touch."""

import numpy as np
import pytest

from slider.env.ground import FLAT
from slider.env.instruments import CONTACT_FORCE, LIFT_TIME, TOUCH_TIME, join, observe, touchdowns

TIMESTEP = 0.005
COUNT = 100


def left_foot(*spans: tuple[int, int]) -> np.ndarray:
    """Forces (COUNT, 1, 2) of a left foot that is down from the first to before the second."""
    forces = np.zeros((COUNT, 1, 2))
    for start, stop in spans:
        forces[start:stop, 0, 0] = 50.0
    return forces


@pytest.mark.parametrize(
    ("spans", "expected"),
    [
        ([(20, 60)], [20]),
        ([(0, 30), (50, 80)], [50]),  # down at first
        ([(20, 25), (30, 60)], [20]),  # up for 25 ms
        ([(20, 25), (31, 60)], [20, 31]),  # up for 30 ms
        ([(20, 22), (24, 25), (27, 29), (30, 60)], [20]),  # rattles as it lands
        ([(20, 23), (60, 80)], [60]),  # grazes the ground for 15 ms
        ([(20, 24), (60, 80)], [20, 60]),  # 20 ms
        ([(20, 60), (90, 100)], [20, 90]),  # down at last
        ([(20, 60), (98, 100)], [20, 98]),  # for how long, nobody knows
        ([], []),
        ([(0, 100)], []),
    ],
)
def test_touchdowns_without_bounces(spans, expected):
    assert (LIFT_TIME, TOUCH_TIME) == (0.03, 0.02), "the spans are for these"
    found = touchdowns(left_foot(*spans), TIMESTEP)
    assert np.flatnonzero(found[:, 0, 0]).tolist() == expected
    assert not found[:, 0, 1].any()


def test_bounces_are_told_by_time_not_by_steps():
    """Up for 24 ms in steps of 1 ms."""
    forces = left_foot((10, 40), (64, 100))
    assert touchdowns(forces, 0.001).sum() == 1
    assert touchdowns(forces, TIMESTEP).sum() == 2


def test_robots_and_feet_are_told_apart():
    one, other = left_foot((20, 25), (30, 60)), left_foot((40, 90))[..., ::-1]
    both = np.concatenate([one, other], axis=1)
    found = touchdowns(both, TIMESTEP)
    assert np.argwhere(found).tolist() == [[20, 0, 0], [40, 1, 1]]


def feet(heights: list[list[float]], forces: list[float]):
    """Contacts of one robot in one step, of heights (foot, end) [m] and forces [N]."""
    ends = np.zeros((1, 1, 2, 2, 3))
    ends[..., 2] = heights
    velocities = np.tile([0.3, -0.4, 9.0], (1, 1, 2, 2, 1))
    return observe(np.array([[forces]]), ends, velocities, np.array([[[0.2, 0.1, 0.3]]]), FLAT)


def test_loaded_ends_are_those_that_sank_in_or_the_lower_one():
    found = feet([[-1e-3, 1e-3], [-1e-3, -2e-3]], [50.0, 50.0])
    assert found.loaded[0, 0].tolist() == [[True, False], [True, True]]
    found = feet([[2e-3, 1e-3], [-1e-3, -2e-3]], [50.0, CONTACT_FORCE])
    assert found.loaded[0, 0].tolist() == [[False, True], [False, False]]
    np.testing.assert_allclose(found.speeds, 0.5, rtol=1e-6)
    np.testing.assert_allclose(found.leg_distance, [[0.1]], rtol=1e-6)


def test_stretches_of_time_are_joined_in_order():
    first, second = (feet([[0, 0], [0, 0]], [force, 0.0]) for force in (10.0, 20.0))
    joined = join([first, second])
    np.testing.assert_array_equal(joined.forces[:, 0, 0], [10.0, 20.0])
    assert joined.loaded.shape == (2, 1, 2, 2)
