"""Steps, limit cycles, return maps and invariance of two real gaits, executed."""

from dataclasses import replace

import numpy as np
import pytest

from slider.config.hzd import ImpactGrid
from slider.core.arrays import take
from slider.gait.outputs import ANKLE, YAW, output_matrix
from slider.hzd.feedback import regulate
from slider.hzd.plans import motion, start
from slider.hzd.return_map import invariance
from slider.hzd.step import ClosedLoop, _Steps
from slider.hzd.walk import chain, differences, multipliers
from tests.env.synthetic import GEOMETRY
from tests.hzd.sample import CLOCK, HIP, library, loop, one, points, settings, steps, walks, zero

NUM = 11
both = pytest.mark.parametrize("gait", [CLOCK, HIP])


def coordinates(at) -> np.ndarray:
    """ξ (4,) of a single state."""
    return np.r_[at.com[0, 1], at.com_rate[0, 1], at.com_rate[0, 0], at.com[0, 0]]


def test_the_hip_table_is_the_hip_of_the_gait_between_its_nodes():
    phase = np.full(2, 0.413)
    for plan in steps():
        q, rate, turn = motion(plan, phase, settings())
        _, _, slope, bend = loop().model.constrained(q, rate)
        hip = loop().model.measure(q, rate).hip
        expected = hip, (slope * rate).sum(axis=1), bend + (slope * turn).sum(axis=1)
        for found, value in zip(plan.hip.at(phase), expected, strict=True):
            np.testing.assert_allclose(found[:, 0], value, atol=1e-6)


def test_a_step_from_the_collocated_gait_ends_where_the_gait_does():
    """Up to the collocation's error of the roll, which the integration does not have."""
    flow = loop().step(steps()[0], start(steps()[0], settings()))
    assert flow.alive.all()
    np.testing.assert_allclose(flow.phase, 1.0, atol=1e-3)
    np.testing.assert_allclose(flow.time, library().arrays["step_time"][:, 0], atol=1e-3)
    np.testing.assert_allclose(flow.landed.state, start(steps()[1], settings()), atol=1e-2)


@pytest.mark.parametrize("ankle", ["free", "driven"])
@both
def test_accelerations_are_those_of_efforts_that_meet_the_outputs(gait, ankle):
    """M q̈ + h = B u; ÿ = −k_p y − k_d ẏ with the s̈ that q̈ gives; what the ankle does."""
    plan, config = one(gait)[0], replace(settings(), ankle=ankle)
    rng = np.random.default_rng(gait)
    phase = np.array([0.6])
    q, rate, _ = motion(plan, phase, config)
    q = q + 0.01 * rng.standard_normal(q.shape)
    v = rate / plan.duration + 0.1 * rng.standard_normal(q.shape)
    model = loop().model
    _, _, slope, bend = model.constrained(q, v)
    _, hip_slope, hip_bend = (float(order[0, 0]) for order in plan.hip.at(phase))
    nominal = 1 / plan.duration[0]
    speed = nominal if gait == CLOCK else float(slope[0] @ v[0]) / hip_slope

    size = 1e-5
    moved = _advanced(plan, phase, q, v, size, config) - _advanced(plan, phase, q, v, -size, config)
    found = moved[NUM : 2 * NUM] / (2 * size) * speed
    turn = 0.0
    if gait == HIP:
        turn = (float(slope[0] @ found + bend[0]) - hip_bend * speed**2) / hip_slope
    desired, first, second = (order[0] for order in motion(plan, phase, config))
    rows = np.delete(output_matrix(config.outputs, GEOMETRY), YAW, axis=1)
    y, y_rate = rows @ (q[0] - desired), rows @ (v[0] - first * speed)
    missed = rows @ (found - second * speed**2 - first * turn) + config.kp * y + config.kd * y_rate
    mass, bias = model.symbols.dynamics(q[0], v[0])
    efforts = mass.full() @ found + bias.full()[:, 0]
    kept = np.ones(10, bool)
    kept[ANKLE] = ankle == "driven" and gait == CLOCK
    np.testing.assert_allclose(missed[kept], 0.0, atol=1e-4)
    np.testing.assert_allclose(efforts[0], 0.0, atol=1e-4)
    if ankle == "free":
        own = plan.ankle.at(phase)[0][0, 0]
        np.testing.assert_allclose(efforts[1 + ANKLE], own, atol=1e-4)
    elif gait == HIP:
        np.testing.assert_allclose(turn, -config.rate_gain * (speed - nominal), atol=1e-4)


def _advanced(plan, phase, q, v, width, config):
    steps_ = _Steps(ClosedLoop(loop().model, config), plan, plan.constraints(config))
    return steps_._advance(phase, np.c_[q, v, 0.0], np.array([width]))[0]


def test_outputs_stay_zero_on_the_limit_cycle_and_after_any_impact_with_re_anchoring():
    """Without it an impact leaves them at more than 0.1 rad/s, and a step ends with a rest."""
    grid = ImpactGrid([-0.02, 0.02], [-0.1, 0.1])
    found = invariance(loop(), steps(), points(), grid)
    assert (found["invariance_orbit"] < 1e-8).all()
    assert (found["invariance_anchored"] < 1e-6).all()
    assert (found["invariance_impact"] > 0.1).all()
    assert (found["invariance_free"] > 1e3 * found["invariance_anchored"]).all()
    assert (found["settle_angle"] < 0.01).all()
    joints = ClosedLoop(loop().model, replace(settings(), outputs="joints", phase="time"))
    clocks = [replace(plan, clock=np.full(2, True)) for plan in steps()]
    found = invariance(joints, clocks, points(), ImpactGrid([0.002], [-0.01]))
    assert (found["invariance_anchored"] < 1e-6).all()


@both
def test_the_walk_returns_to_its_points(gait):
    found = walks()[gait]
    for step in range(2):
        flow = loop().step(one(gait)[step], found.points[step][None])
        np.testing.assert_allclose(flow.landed.state[0], found.points[1 - step], atol=1e-8)
        seen = coordinates(loop().model.measure(flow.q[10], flow.v[10]))
        np.testing.assert_allclose(zero(gait).orbit[step, 0, 10], seen, atol=1e-8)


@both
def test_the_return_map_has_the_rank_of_the_zero_dynamics(gait):
    found = walks()[gait]
    rank = 4 if gait == CLOCK else 3
    for derivative in found.derivatives:
        values = np.linalg.svd(derivative, compute_uv=False)
        assert values[rank] < 1e-3 * values[0]
    assert found.maps.shape == (2, rank, rank)
    whole, restricted = multipliers(found.derivatives), np.linalg.eigvals(chain(found.maps))
    order = np.argsort(-np.abs(restricted))
    np.testing.assert_allclose(np.abs(restricted[order]), np.abs(whole[:rank]), atol=1e-4)


@both
def test_a_few_directions_give_the_foot_placement_of_the_whole_return_map(gait):
    """22 columns of its derivative, from section to section, against those that count."""
    found = regulate(zero(gait), 0, settings().feedback)
    for name in ("gains", "phase_gains"):
        expected = getattr(walks()[gait].regulator, name)
        np.testing.assert_allclose(getattr(found, name), expected, atol=1e-5)
    np.testing.assert_allclose(zero(gait).maps[:, 0], walks()[gait].maps, atol=1e-5)


@both
def test_foot_placement_stabilises_the_executed_walk(gait):
    """The closed loop's own differences have the eigenvalues of A − B K."""
    found, plans = walks()[gait], one(gait)
    assert np.abs(multipliers(found.derivatives)[0]) > 2.0
    executed = []
    for step, plan in enumerate(plans):

        def walked(x, rows, step=step, plan=plan):
            return loop().step(take(plan, rows), x, found.displacement(step, x, 1.0)).landed.state

        executed.append(differences(walked, found.points[step][None], 1e-5)[1][0])
    expected = np.abs(np.linalg.eigvals(chain(found.closed))).max()
    assert expected < 0.6
    np.testing.assert_allclose(np.abs(multipliers(executed)[0]), expected, atol=2e-3)
    np.testing.assert_allclose(
        np.abs(multipliers(found.closed_derivatives)[0]), expected, atol=1e-4
    )


@both
def test_gains_over_the_phase_ask_for_the_same_step(gait):
    """A perturbed walk whose foot is displaced by b measures ξ(s) with b = −K(s) (ξ − ξ*)."""
    found, plan = walks()[gait], one(gait)[0]
    gains, size = found.regulator.phase_gains, 1e-4
    rows = np.delete(output_matrix(settings().outputs, GEOMETRY), YAW, axis=1)
    turn = np.linalg.svd(rows)[2][-1]
    x = found.points[0] + size * np.r_[turn, 3.0 * turn]
    b = found.displacement(0, x[None], 1.0)
    flow = loop().step(plan, x[None], b)
    for k in (0, 10, 14, 20):
        seen = coordinates(loop().model.measure(flow.q[k], flow.v[k]))
        expected = -gains[0, k] @ (seen - zero(gait).orbit[0, 0, k])
        np.testing.assert_allclose(expected, b[0], rtol=0.02, atol=1e-2 * np.abs(b).max())
    assert not gains[..., 3].any() or gait == CLOCK
