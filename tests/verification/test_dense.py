"""Between the nodes: consistent with the nodes, and sensitive to limits."""

from dataclasses import replace

import numpy as np
import pytest

from slider.verification.dense import between_nodes, resample
from tests.verification.sample import config, gaits, pinocchio


def worst(**changes) -> dict[str, float]:
    given = {"robot": config().robot, "posture": config().gait.posture, "points": 81} | changes
    return between_nodes(gaits()[1], pinocchio(), **given)


@pytest.mark.parametrize("step", [0, 1])
def test_at_the_nodes_it_is_what_the_library_stores(step):
    gait = gaits()[1]
    own = slice(step * gait.half, (step + 1) * gait.half)
    found = resample(gait.steps[step], pinocchio(), gait.half)
    np.testing.assert_allclose(found.torques, gait.knee_torques[own], atol=1e-5)
    np.testing.assert_allclose(found.wrench, gait.ground_wrench[own], atol=1e-5)
    np.testing.assert_allclose(found.defect, 0.0, atol=1e-6)


def test_shares_follow_the_limits():
    robot = config().robot
    half = {n: replace(x, effort=x.effort / 2, speed=x.speed / 4) for n, x in robot.limits.items()}
    before, after = worst(), worst(robot=replace(robot, limits=half))
    for name in ("dense_torque", "dense_slide_force"):
        assert after[name] == pytest.approx(2 * before[name])
    for name in ("dense_speed", "dense_slide_speed"):
        assert after[name] == pytest.approx(4 * before[name])


def test_positions_beyond_a_range_show():
    robot = config().robot
    tight = robot.limits | {"slide": replace(robot.limits["slide"], lower=0.0)}
    assert worst()["dense_position"] < 1e-2
    assert worst(robot=replace(robot, limits=tight))["dense_position"] > 0.02


def test_a_higher_clearance_is_missed_by_more():
    posture = config().gait.posture
    before = worst()["dense_clearance"]
    after = worst(posture=replace(posture, clearance=posture.clearance + 0.05))["dense_clearance"]
    assert after > before + 0.01


def test_more_points_find_no_less():
    assert worst(points=81)["dense_clearance"] >= worst(points=21)["dense_clearance"]
    assert worst(points=81)["dense_roll_defect"] > 1e-3 > worst(points=21)["dense_roll_defect"]
