"""Virtual constraints of a step, re-anchored after the impact; the hip as a phase."""

from dataclasses import replace

import numpy as np
import pytest

from slider.core.arrays import take
from slider.core.errors import UserError
from slider.gait.outputs import JOINTS, SWING
from slider.hzd.constraints import phase_of
from slider.hzd.plans import StepPlan, plans
from tests.gait.gaits import config
from tests.hzd.sample import CLOCK, HIP, library, loop, settings, steps


def anchored():
    rng, constraints = np.random.default_rng(3), steps()[0].constraints(settings())
    at = np.full(len(constraints.steps.coefficients), 0.05)
    value, slope, _ = constraints.desired(at)
    moved = value + rng.normal(0, 0.02, value.shape), slope + rng.normal(0, 0.3, slope.shape)
    constraints.re_anchor(at, *moved)
    return constraints, at


def test_the_re_anchoring_is_gone_by_mid_step_with_two_derivatives():
    constraints, at = anchored()
    nominal = steps()[0].constraints(settings())
    middle = np.full(len(at), settings().correction_end)
    for found, expected in zip(constraints.desired(middle), nominal.desired(middle), strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-9)


def test_derivatives_over_the_phase_are_those_of_the_values():
    constraints, at = anchored()
    constraints.displacement = np.full((len(at), 2), 0.03)
    h = 1e-5
    for phase in (0.21, 0.43, 0.61, 0.91, 1.06):
        above, below = (constraints.desired(np.full(len(at), phase + d)) for d in (h, -h))
        now = constraints.desired(np.full(len(at), phase))
        for order in range(2):
            slope = (above[order] - below[order]) / (2 * h)
            np.testing.assert_allclose(now[order + 1], slope, atol=2e-5, rtol=1e-6)


def test_a_displaced_foothold_moves_the_swing_leg_alone():
    plain, moved = (steps()[0].constraints(settings()) for _ in range(2))
    moved.displacement[:] = [0.05, -0.04]
    end = np.ones(len(plain.steps.coefficients))
    change = np.abs(moved.desired(end)[0] - plain.desired(end)[0])
    assert (change[:, :SWING] == 0).all()
    assert (change[:, SWING:].max(axis=1) > 0.01).all()
    assert JOINTS < SWING


def test_a_slide_that_is_displaced_keeps_the_height_of_its_foot_to_second_order():
    """Also where gaits have no virtual knee; a leg with a knee has no such term."""
    plan, leg = steps()[0], config().robot.geometry.leg_length
    own, knee = replace(plan, lengths=None), replace(plan, lengths=None, slide_length=None)
    moves = [displaced(each, [0.05, -0.04]) - displaced(each, [0.0, 0.0]) for each in (own, knee)]
    linear = 0.05 * plan.placement[:, :, 0] - 0.04 * plan.placement[:, :, 1]
    np.testing.assert_allclose(moves[1], linear, atol=1e-12)
    np.testing.assert_allclose((moves[0] - moves[1])[:, 8], 0.0041 / (2 * leg), atol=1e-12)


def displaced(plan: StepPlan, move: list[float]) -> np.ndarray:
    """Joints (n, 10) at the end of steps whose foot is displaced [m]."""
    constraints = plan.constraints(settings())
    constraints.displacement[:] = move
    return constraints.desired(np.ones(len(plan.duration)))[0][:, JOINTS:]


def test_a_hip_that_turns_back_is_named(monkeypatch):
    config, constrained = settings(), loop().model.constrained

    def turned_back(*arguments):
        rows, bias, slope, bend = constrained(*arguments)
        return rows, bias, -slope, bend

    monkeypatch.setattr(loop().model, "constrained", turned_back)
    plans(library(), np.array([CLOCK]), loop().model, config)
    with pytest.raises(UserError, match=r"turns back in the gait \(0\.6, 0\.1\) m/s"):
        plans(library(), np.array([CLOCK, HIP]), loop().model, config)


def test_a_robot_that_is_lost_has_no_place_and_does_not_disturb_the_others():
    table = take(steps()[0].hip, np.array([HIP, HIP]))
    found = phase_of(table, np.array([np.nan, table.at(np.full(2, 0.3))[0][0, 0]]))
    assert np.isnan(found[0])
    assert found[1] == pytest.approx(0.3, abs=1e-9)
