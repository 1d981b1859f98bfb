"""Gaits of a robot with soles: good ones pass, and what was spoiled is found."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from slider.verification.pin_robot import PinRobot
from slider.verification.stage import Check
from tests.robot.lopsided import soled
from tests.verification.sample import failed, spoiled, table_of
from tests.verification.sample import gait_with_soles as gait

QUICK = ("dynamics", "impact", "periodicity", "plant", "plant_impact")


@cache
def table() -> dict[str, Check]:
    return table_of(soled())


@pytest.mark.parametrize("velocity", [(0.3, 0.0, 0.0), (0.4, -0.05, 0.2)])
def test_solved_gaits_pass(velocity):
    assert failed(gait(velocity), table()) == set()


@pytest.mark.parametrize(
    ("array", "index", "amount", "caught"),
    [
        ("samples", (5, 11), 1e-3, {"dynamics_base", "dynamics_efforts", "plant_efforts"}),
        ("samples", (30, 11), 1e-3, {"dynamics_base", "plant_moment"}),  # stance
        ("samples", (20, 17), 1e-3, {"impact_velocity", "plant_impact"}),
        ("samples", (21, 5), 1e-3, {"periodicity"}),
        ("efforts", (5, 11), 1e-5, {"dynamics_efforts", "plant_efforts"}),
        ("efforts", (5, 5), 1e-5, {"dynamics_line_moment", "dynamics_efforts"}),
        ("ground_wrench", (7, 3), 1e-5, {"dynamics_base", "plant_moment"}),
        ("roll", (0, 9, 2), 1e-3, {"dynamics_efforts", "dynamics_line_moment"}),
    ],
)
def test_spoiled_gaits_are_caught(array, index, amount, caught):
    assert caught <= failed(spoiled(gait(), array, index, amount), table(), *QUICK)


def test_a_narrow_sole_tips():
    narrow = replace(soled().geometry.sole, width=0.01)
    other = replace(soled(), geometry=replace(soled().geometry, sole=narrow))
    assert failed(gait(), table_of(other), "plant", "dense") == {"plant_cop", "dense_cop"}


def test_soles_are_level_along_a_motion():
    """Angle, rate and acceleration of the swing ankle's roll against finite differences."""
    robot, motion, step = PinRobot(soled(), "prismatic"), gait().steps[1], 1e-5
    before, now, after = (robot.moving(motion, 0.2 + way) for way in (-step, 0.0, step))
    np.testing.assert_allclose(now.v[6:], (after.q - before.q)[7:] / (2 * step), atol=1e-6)
    np.testing.assert_allclose(now.a[6:], (after.v - before.v)[6:] / (2 * step), atol=1e-5)
    standing = robot.jacobian(now.q, motion.side)
    tilt = robot.data.oMf[robot.sole("left")].rotation[2, 1]
    assert tilt == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(standing @ now.v, 0.0, atol=1e-12)
