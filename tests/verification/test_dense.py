"""Between the nodes: consistent with the nodes, and sensitive to limits."""

from dataclasses import replace

import numpy as np
import pytest

from slider.verification.dense import between_nodes, legs_apart, resample
from tests.verification.sample import config, gaits, knee_gait, pinocchio, plant, spoiled


def worst(**changes) -> dict[str, float]:
    given = {"robot": config().robot, "posture": config().gait.posture, "points": 81} | changes
    return between_nodes(gaits()[1], pinocchio(), **given)


@pytest.mark.parametrize("dynamics", ["prismatic", "knee"])
@pytest.mark.parametrize("step", [0, 1])
def test_at_the_nodes_it_is_what_the_library_stores(dynamics, step):
    gait = gaits()[1] if dynamics == "prismatic" else knee_gait()
    own = slice(step * gait.half, (step + 1) * gait.half)
    found = resample(gait.steps[step], pinocchio(dynamics), gait.half)
    np.testing.assert_allclose(found.efforts, gait.efforts[own], atol=1e-5)
    np.testing.assert_allclose(found.wrench, gait.ground_wrench[own], atol=1e-5)
    np.testing.assert_allclose(found.joints, gait.samples[own, :12], atol=1e-9)
    np.testing.assert_allclose(found.speeds, gait.samples[own, 12:24], atol=1e-9)


def test_shares_follow_the_limits():
    robot = config().robot
    weak = {n: replace(x, torque=x.torque / 2, speed=x.speed / 2) for n, x in robot.drives.items()}
    slow = {n: replace(x, speed=x.speed / 2) for n, x in robot.drives.items()}
    before, after = worst(), worst(robot=replace(robot, drives=weak))
    assert after["dense_torque"] == pytest.approx(2 * before["dense_torque"])
    assert after["dense_voltage"] == pytest.approx(2 * before["dense_voltage"])
    other = worst(robot=replace(robot, drives=slow))
    assert other["dense_torque"] == before["dense_torque"]
    assert before["dense_voltage"] < other["dense_voltage"] < after["dense_voltage"]


def test_positions_beyond_a_range_and_a_higher_clearance_show():
    robot, posture, before = config().robot, config().gait.posture, worst()
    tight = robot.joints | {"slide": replace(robot.joints["slide"], upper=0.0)}
    assert before["dense_position"] == 0.0
    assert worst(robot=replace(robot, joints=tight))["dense_position"] > 0.02
    assert before["dense_clearance"] < 0.003
    higher = replace(posture, clearance=posture.clearance + 0.05)
    assert 0.015 < worst(posture=higher)["dense_clearance"] < 0.03  # it swings higher than it must


def test_legs_are_as_far_apart_as_their_feet_at_most():
    """Of two parallel feet the middles of the lines are two radii further apart."""
    gait = gaits()[1]
    found = legs_apart(gait, plant(), gait.half)["dense_leg_distance"]
    sideways = np.hypot(*gait.swing_foot[:, :2].T) - 2 * config().robot.geometry.foot_radius
    assert 0.03 < found <= sideways.min()


def test_legs_that_cross_show():
    """Hip rolls inwards."""
    gait = spoiled(gaits()[1], "coefficients", np.s_[:, [1, 6]], [[[-0.2], [0.2]]])
    assert legs_apart(gait, plant(), 21)["dense_leg_distance"] < 0


def test_a_gait_that_is_not_a_number_passes_no_bound():
    gait = spoiled(gaits()[1], "coefficients", ..., np.nan)
    checks = between_nodes(gait, pinocchio(), config().robot, config().gait.posture, 3)
    assert np.isnan(list(checks.values())).all()
