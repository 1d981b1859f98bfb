"""Eq. 1 by geometry and as printed, and as a change of coordinates: derivatives and work."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from slider.config.robot import VirtualKnee
from slider.gait.tree import LegMap
from slider.robot import knee_map
from slider.verification.pin_robot import slide_jacobian
from tests.env.synthetic import GEOMETRY
from tests.gait.gaits import config

L1 = L2 = 0.36
THETA = np.linspace(0.1, 1.2, 2001)
LENGTHS, STEP = knee_map.KneeLengths(0.39, 0.35, 0.64), 1e-5


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


def test_samples_are_converted_by_the_variant_that_is_asked_for():
    q, v = np.random.default_rng(2).uniform(0.1, 1.2, (2, 7, 10))
    position, velocity = knee_map.prismatic_joints(q, v, config().robot, "paper")
    terms = knee_map.triangle(q[:, 3::5], L1, L2, "paper")
    np.testing.assert_array_equal(position[:, 2::6], q[:, 2::5] - terms.shifts[0])
    np.testing.assert_array_equal(velocity[:, 2::6], v[:, 2::5] - terms.rates[0] * v[:, 3::5])
    assert not position[:, 5::6].any(), "upper feet rest"


def test_the_mirror_swaps_the_legs_and_flips_yaw_and_roll():
    left, right = np.arange(1.0, 6.0), np.arange(11.0, 16.0)
    found = knee_map.reflected(np.concatenate([left, right]), GEOMETRY)
    np.testing.assert_array_equal(found, [-11, -12, 13, 14, 15, -1, -2, 3, 4, 5])
    np.testing.assert_array_equal(
        knee_map.reflected(found, GEOMETRY), np.concatenate([left, right])
    )


@pytest.fixture(scope="module")
def leg_map() -> LegMap:
    robot = config().robot
    geometry = replace(robot.geometry, leg_length=LENGTHS.nominal)
    knee = VirtualKnee(LENGTHS.thigh, LENGTHS.shank, 0.3)
    return LegMap.of(replace(robot, geometry=geometry, virtual_knee=knee))


def motion(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    q, v, a = rng.normal(size=(3, 10)) * [[0.3], [2.0], [20.0]]
    q[[3, 8]] = rng.uniform(0.2, 1.6, 2)
    return q, v, a


def number(value) -> np.ndarray:
    return np.array(ca.DM(value)).ravel()


@pytest.mark.parametrize("seed", range(5))
def test_velocities_and_accelerations_are_derivatives(leg_map, seed):
    q, v, a = motion(seed)
    place = [number(leg_map.positions(q + t * v + t**2 / 2 * a)) for t in (-STEP, 0.0, STEP)]
    rate = [number(leg_map.velocities(q + t * v + t**2 / 2 * a, v + t * a)) for t in (-STEP, STEP)]
    slope, bend = (place[2] - place[0]) / (2 * STEP), (rate[1] - rate[0]) / (2 * STEP)
    np.testing.assert_allclose(number(leg_map.velocities(q, v)), slope, atol=1e-6)
    np.testing.assert_allclose(number(leg_map.accelerations(q, v, a)), bend, atol=1e-5)
    assert np.abs(bend - number(leg_map.velocities(q, a))).max() > 0.1  # J̇ q̇ counts


@pytest.mark.parametrize("seed", range(5))
def test_torques_do_the_work_of_efforts(leg_map, seed):
    q, v, _ = motion(seed)
    efforts = np.random.default_rng(seed).normal(size=10)
    torques = number(leg_map.knee_torques(q, efforts))
    assert torques @ v == pytest.approx(efforts @ number(leg_map.velocities(q, v)), rel=1e-12)
    np.testing.assert_allclose(number(leg_map.efforts(q, torques)), efforts, atol=1e-12)


def test_the_expressions_of_gaits_and_the_map_of_samples_are_equal(leg_map):
    walk = [motion(seed) for seed in range(5)]
    q, v, a = (np.array(column) for column in zip(*walk, strict=True))
    sampled = knee_map.prismatic_motion(q, v, a, LENGTHS)
    for (q, v, a), *found in zip(walk, *sampled, strict=True):
        place, rates = number(leg_map.positions(q)), number(leg_map.velocities(q, v))
        expected = place, rates, number(leg_map.accelerations(q, v, a))
        np.testing.assert_allclose(found, expected, atol=1e-12)
        np.testing.assert_allclose(slide_jacobian(q, LENGTHS) @ v, rates, atol=1e-12)
