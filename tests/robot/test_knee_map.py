import numpy as np
import pytest

from slider.robot import knee_map
from tests.env.synthetic import GEOMETRY
from tests.gait.gaits import config

L1 = L2 = 0.36
THETA = np.linspace(0.1, 1.2, 2001)


@pytest.mark.parametrize(("l1", "l2"), [(0.36, 0.36), (0.40, 0.32), (0.30, 0.42)])
def test_exact_positions_put_the_ankle_where_the_knee_leg_has_it(l1, l2):
    rng = np.random.default_rng(0)
    hip, ankle = rng.uniform(-0.6, 0.6, (2, 100))
    theta = rng.uniform(0.05, 1.7, 100)
    leg = knee_map.triangle(theta, l1, l2)
    hip_pitch, own_ankle = hip - leg.shifts[0], ankle - leg.shifts[1]
    # Rotation by angle a about +y takes (0, −l) in the x-z plane to (−l sin a, −l cos a).
    shank = hip - theta
    x = -l1 * np.sin(hip) - l2 * np.sin(shank)
    z = -l1 * np.cos(hip) - l2 * np.cos(shank)
    np.testing.assert_allclose(-leg.length * np.sin(hip_pitch), x, atol=1e-14)
    np.testing.assert_allclose(-leg.length * np.cos(hip_pitch), z, atol=1e-14)
    np.testing.assert_allclose(hip_pitch + own_ankle, shank + ankle, atol=1e-14)


def test_paper_variant_is_the_matrix_as_printed():
    length = np.sqrt(L1**2 + L2**2 + 2 * L1 * L2 * np.cos(THETA))
    leg = knee_map.triangle(THETA, L1, L2, "paper")
    np.testing.assert_allclose(leg.shifts, [L2 / length * THETA, L1 / length * THETA])
    np.testing.assert_allclose(leg.length, length)
    share = np.cos(THETA)
    rates = [L2 / length * share, L1 / length * share, -2 * L1 * L2 * share]
    np.testing.assert_allclose(leg.rates, rates)


@pytest.mark.parametrize("variant", ["exact", "paper"])
def test_both_legs_are_converted_each_by_itself_and_upper_feet_rest(variant):
    rng, robot = np.random.default_rng(2), config().robot
    q, v = rng.uniform(0.1, 1.2, (2, 7, 10))
    position, velocity = knee_map.prismatic_joints(q, v, robot, variant)
    legs, rates = (np.moveaxis(each.reshape(7, 2, 5), -1, 0) for each in (q, v))
    terms = knee_map.triangle(legs[3], L1, L2, variant)
    slide = terms.length - robot.geometry.leg_length
    sagittal = [legs[2] - terms.shifts[0], slide, legs[4] - terms.shifts[1]]
    expected = np.stack([*legs[:2], *sagittal, 0 * slide], axis=-1)
    np.testing.assert_array_equal(position, expected.reshape(7, 12))
    hip, ankle, along = (slope * rates[3] for slope in terms.rates)
    expected = np.stack([*rates[:2], rates[2] - hip, along, rates[4] - ankle, 0 * slide], axis=-1)
    np.testing.assert_array_equal(velocity, expected.reshape(7, 12))


def test_the_mirror_swaps_the_legs_and_flips_yaw_and_roll():
    left, right = np.arange(1.0, 6.0), np.arange(11.0, 16.0)
    found = knee_map.reflected(np.concatenate([left, right]), GEOMETRY)
    np.testing.assert_array_equal(found, [-11, -12, 13, 14, 15, -1, -2, 3, 4, 5])
    np.testing.assert_array_equal(
        knee_map.reflected(found, GEOMETRY), np.concatenate([left, right])
    )
