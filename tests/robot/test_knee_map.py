import numpy as np
import pytest

from slider.robot import knee_map
from tests.gait.gaits import config

L1 = L2 = 0.36
THETA = np.linspace(0.1, 1.2, 2001)
LENGTHS = [(0.36, 0.36), (0.40, 0.32), (0.30, 0.42)]


@pytest.mark.parametrize(("l1", "l2"), LENGTHS)
def test_exact_positions_put_the_ankle_where_the_knee_leg_has_it(l1, l2):
    rng = np.random.default_rng(0)
    hip, ankle = rng.uniform(-0.6, 0.6, (2, 100))
    theta = rng.uniform(0.05, 1.7, 100)
    leg = knee_map.positions(hip, theta, ankle, l1, l2)
    # Rotation by angle a about +y takes (0, −l) in the x-z plane to (−l sin a, −l cos a).
    shank = hip - theta
    x = -l1 * np.sin(hip) - l2 * np.sin(shank)
    z = -l1 * np.cos(hip) - l2 * np.cos(shank)
    np.testing.assert_allclose(-leg.length * np.sin(leg.hip_pitch), x, atol=1e-14)
    np.testing.assert_allclose(-leg.length * np.cos(leg.hip_pitch), z, atol=1e-14)
    np.testing.assert_allclose(leg.hip_pitch + leg.ankle, shank + ankle, atol=1e-14)


@pytest.mark.parametrize(("l1", "l2"), LENGTHS)
def test_exact_velocities_are_the_derivative_of_the_positions(l1, l2):
    h = 1e-6
    theta, zero = THETA, np.zeros_like(THETA)
    above = knee_map.positions(zero, theta + h, zero, l1, l2)
    below = knee_map.positions(zero, theta - h, zero, l1, l2)
    rate = knee_map.velocities(zero, theta, np.ones_like(theta), zero, l1, l2)
    for name in ("hip_pitch", "length", "ankle"):
        slope = (getattr(above, name) - getattr(below, name)) / (2 * h)
        np.testing.assert_allclose(getattr(rate, name), slope, atol=1e-9)


def test_paper_variant_is_the_matrix_as_printed():
    one = np.ones_like(THETA)
    length = np.sqrt(L1**2 + L2**2 + 2 * L1 * L2 * np.cos(THETA))
    leg = knee_map.positions(0.3 * one, THETA, -0.2 * one, L1, L2, "paper")
    np.testing.assert_allclose(leg.hip_pitch, 0.3 - L2 / length * THETA)
    np.testing.assert_allclose(leg.ankle, -0.2 - L1 / length * THETA)
    np.testing.assert_allclose(leg.length, length)
    speed = knee_map.velocities(0.3 * one, THETA, 2 * one, -0.2 * one, L1, L2, "paper")
    np.testing.assert_allclose(speed.hip_pitch, 0.3 - L2 / length * np.cos(THETA) * 2)
    np.testing.assert_allclose(speed.ankle, -0.2 - L1 / length * np.cos(THETA) * 2)
    np.testing.assert_allclose(speed.length, -2 * L1 * L2 * np.cos(THETA) * 2)


@pytest.mark.parametrize("variant", ["exact", "paper"])
def test_both_legs_are_converted_each_by_itself_and_upper_feet_rest(variant):
    rng, robot = np.random.default_rng(2), config().robot
    q, v = rng.uniform(0.1, 1.2, (2, 7, 10))
    lengths = robot.virtual_knee.thigh_length, robot.virtual_knee.shank_length
    position, velocity = knee_map.prismatic_joints(q, v, robot, variant)
    for first, to in ((0, 0), (5, 6)):
        yaw, roll, pitch, theta, ankle = q[:, first : first + 5].T
        speeds = v[:, first : first + 5].T
        place = knee_map.positions(pitch, theta, ankle, *lengths, variant)
        rate = knee_map.velocities(speeds[2], theta, speeds[3], speeds[4], *lengths, variant)
        slide = place.length - robot.geometry.leg_length
        expected = [yaw, roll, place.hip_pitch, slide, place.ankle, 0 * yaw]
        np.testing.assert_array_equal(position[:, to : to + 6], np.stack(expected, axis=1))
        expected = [*speeds[:2], rate.hip_pitch, rate.length, rate.ankle, 0 * yaw]
        np.testing.assert_array_equal(velocity[:, to : to + 6], np.stack(expected, axis=1))


def test_the_mirror_swaps_the_legs_and_flips_yaw_and_roll():
    left, right = np.arange(1.0, 6.0), np.arange(11.0, 16.0)
    found = knee_map.reflected(np.concatenate([left, right]))
    np.testing.assert_array_equal(found, [-11, -12, 13, 14, 15, -1, -2, 3, 4, 5])
    np.testing.assert_array_equal(knee_map.reflected(found), np.concatenate([left, right]))
