"""The hip, and coordinates that count from uneven ground, by closed forms and differences."""

import numpy as np
import pytest

from slider.control.hzd.motion import hip, terrain_motion
from slider.control.whole_body.memory import RIGHT, Memory
from slider.env.height_field import FLAT
from slider.gait.outputs import ANKLE, STANCE, SWING
from tests.control.hzd.test_steps import COUNT, ROBOTS, standing

SLOPE = np.array([0.1, -0.05])  # rise over run along x and y
FOOTHOLDS = np.tile([[0.0, 0.1], [-0.3, -0.1], [0.4, -0.1]], (COUNT, 1, 1))
SLIDES = [STANCE + 3, SWING + 3]
ANKLES = [STANCE + ANKLE, SWING + ANKLE]


class Ground:
    """A plane, and a step behind x = 0.2 m."""

    flat = False

    def __init__(self, slope: np.ndarray, rise: float = 0.0) -> None:
        self._slope, self._rise = slope, rise

    def height(self, points: np.ndarray, gaps: bool = True) -> np.ndarray:
        return points @ self._slope + self._rise * (points[..., 0] > 0.2)

    def gradient(self, points: np.ndarray) -> np.ndarray:
        return np.broadcast_to(self._slope, points.shape)

    def of(self, robots: np.ndarray) -> "Ground":
        return self


def change(ground, phase: float, heading: float = 0.0):
    """Of the coordinates, with derivatives."""
    memory = Memory.on_both_feet(np.zeros((COUNT, 3)), np.full(COUNT, heading))
    memory.ground = ground
    stretch = np.tile([0.0, 0.0, 0.0, 1.0, 0.0], (2, 1))
    return terrain_motion(memory, ROBOTS, FOOTHOLDS, np.full(COUNT, phase), stretch, 1.0)


@pytest.mark.parametrize(("phase", "legs"), [(0, [0, 0]), (0.5, [0.01, -0.01]), (1, [0.02, -0.02])])
def test_a_step_up_shortens_the_swing_leg_and_lifts_the_base_by_half(phase, legs):
    value, *_ = change(Ground(np.zeros(2), 0.04), phase)
    np.testing.assert_allclose(value[:, SLIDES], [legs] * COUNT, atol=1e-12)
    assert not np.delete(value, SLIDES, axis=1).any()


@pytest.mark.parametrize(("phase", "foothold"), [(0, 1), (1, 2)])
def test_on_a_slope_both_feet_are_on_the_ground_where_a_step_begins_and_ends(phase, foothold):
    """A leg is longer by as much as its foot is lower than the middle of both."""
    value, *_ = change(Ground(SLOPE), phase)
    way = FOOTHOLDS[0, foothold] - FOOTHOLDS[0, 0]
    np.testing.assert_allclose(value[:, SLIDES], [[way @ SLOPE / 2, -way @ SLOPE / 2]] * COUNT)


@pytest.mark.parametrize(("heading", "steep"), [(0.0, 0.1), (np.pi / 2, -0.05)])
def test_ankles_turn_by_the_slope_along_the_heading(heading, steep):
    value, *_ = change(Ground(SLOPE), 0.3, heading)
    np.testing.assert_allclose(value[:, ANKLES], -np.arctan(steep))


def test_derivatives_are_differences():
    step, ground = 1e-5, Ground(SLOPE, 0.04)
    before, now, after = (change(ground, 0.3 + move) for move in (-step, 0.0, step))
    for order in range(2):
        found = (after[order] - before[order]) / (2 * step)
        np.testing.assert_allclose(now[order + 1], found, atol=1e-8)
    assert np.abs(now[2]).max() > 0.01
    assert not np.any(change(FLAT, 0.3))


def test_the_hip_is_measured_along_the_line_of_the_foot():
    dynamics = standing()
    place, speed = hip(dynamics, np.full(COUNT, RIGHT), np.array([0.0, np.pi / 2]))
    offset = (dynamics.base_position[:, :2] - dynamics.foot_positions[:, RIGHT, :2])[ROBOTS, ROBOTS]
    np.testing.assert_allclose(place, offset)
    np.testing.assert_allclose(speed, dynamics.qvel[ROBOTS, ROBOTS])
