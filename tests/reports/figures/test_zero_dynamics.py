"""Manifold, impact surface and orbit of a solved gait."""

import numpy as np
import pytest

from slider.library.blend import Gait, blend
from slider.library.reader import STORE, GaitLibrary
from slider.reports.figures.zero_dynamics import portrait, swing_height, touchdown
from slider.robot import knee_map
from slider.robot.kinematics import foot_ends, rotation_from_quaternion
from tests.library.solved import solved_library

VELOCITY = 0.6, 0.0
NODES = np.linspace(0.0, 1.0, 21)


@pytest.fixture(scope="module")
def gait() -> Gait:
    return blend(GaitLibrary.load(solved_library(((*VELOCITY, 0.0),)) / STORE), *VELOCITY)


def test_the_swing_foot_is_where_the_gaits_own_base_puts_it(gait):
    """The base that follows from a flat stance foot and its roll is that of the library."""
    joints = gait.joints(0, NODES)[0]
    rotation = rotation_from_quaternion(gait.base[:21, 3:7])
    lowest = foot_ends(gait.library.robot.geometry, rotation, joints)[..., 2].min(axis=2)
    expected = lowest[:, 1] - lowest[:, 0]
    rolls = gait.roll[0, :, 0]
    found = [swing_height(gait, r, NODES[[k]])[0] for k, r in enumerate(rolls)]
    np.testing.assert_allclose(found, expected, atol=1e-6)


def test_the_gait_ends_on_the_impact_surface(gait):
    end = gait.roll[0, -1:, 0]
    assert swing_height(gait, end[0], np.ones(1))[0] == pytest.approx(0.0, abs=1e-6)
    assert touchdown(gait, end)[0] == pytest.approx(1.0, abs=1e-4)
    # The swing foot is to the right: the further the robot leans there, the earlier it lands.
    early, late = touchdown(gait, end + [0.005, -0.005])
    assert early < 1.0 < late


def test_eq_1_takes_the_knees_portrait_to_that_of_the_slide(gait):
    knee, slide = portrait(gait, "right_knee"), portrait(gait, "right_slide")
    robot = gait.library.robot
    l1, l2 = robot.virtual_knee.thigh_length, robot.virtual_knee.shank_length
    for part in ("orbit", "manifold", "image"):
        roll, theta, rate = getattr(knee, part)
        length = knee_map.triangle(theta, l1, l2).length - robot.geometry.leg_length
        speed = knee_map.triangle(theta, l1, l2).rates[2] * rate
        np.testing.assert_allclose(getattr(slide, part), [roll, length, speed], atol=1e-9)


@pytest.mark.parametrize("joint", ["right_knee", "right_slide"])
def test_the_impact_closes_the_orbit(gait, joint):
    """Straight ahead both steps are the same: Δ leads from the end of one to its start."""
    found = portrait(gait, joint)
    np.testing.assert_allclose(found.image, found.orbit[:, 0], atol=1e-5)
    assert abs(found.orbit[2, -1] - found.image[2]) > 0.05  # the impact is no small one


def test_the_manifold_holds_the_orbits_joints(gait):
    found = portrait(gait, "right_slide")
    row = int(np.abs(found.manifold[0, :, 0] - gait.roll[0, -1, 0]).argmin())
    assert found.landed.all()
    np.testing.assert_allclose(found.manifold[1:, row], found.orbit[1:], atol=0.05)
