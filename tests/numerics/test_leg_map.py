"""Eq. 1 as a change of coordinates: derivatives and work."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from slider.config.robot import VirtualKnee
from slider.gait.tree import LegMap
from slider.robot.knee_map import KneeLengths, prismatic_motion
from slider.verification.pin_robot import slide_jacobian
from tests.gait.gaits import config

L1, L2, NOMINAL, STEP = 0.39, 0.35, 0.64, 1e-5
KNEES = [3, 8]


@pytest.fixture(scope="module")
def leg_map() -> LegMap:
    robot = config().robot
    geometry = replace(robot.geometry, leg_length=NOMINAL)
    return LegMap.of(replace(robot, geometry=geometry, virtual_knee=VirtualKnee(L1, L2, 0.3)))


def motion(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    q, v, a = rng.normal(size=(3, 10)) * [[0.3], [2.0], [20.0]]
    q[KNEES] = rng.uniform(0.2, 1.6, 2)
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
    lengths = KneeLengths(L1, L2, NOMINAL)
    sampled = prismatic_motion(q, v, a, lengths)
    for (q, v, a), *found in zip(walk, *sampled, strict=True):
        place, rates = number(leg_map.positions(q)), number(leg_map.velocities(q, v))
        expected = place, rates, number(leg_map.accelerations(q, v, a))
        np.testing.assert_allclose(found, expected, atol=1e-12)
        np.testing.assert_allclose(slide_jacobian(q, lengths) @ v, rates, atol=1e-12)
