"""Steps, limit cycles, return maps and foot placement of two real gaits, executed."""

import numpy as np
import pytest

from slider.core.arrays import take
from slider.gait.outputs import ANKLE, YAW, output_matrix
from slider.hzd.plans import motion, start
from slider.hzd.regulator import Regulator, regulate
from slider.hzd.step import _Steps
from slider.hzd.walk import differences, multipliers
from tests.env.synthetic import GEOMETRY
from tests.hzd.sample import CLOCK, HIP, library, loop, one, points, settings, steps, whole, zero

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
    np.testing.assert_allclose(flow.after_impact.state, start(steps()[1], settings()), atol=1e-2)


@both
def test_accelerations_are_those_of_efforts_that_meet_the_outputs(gait):
    """M q̈ + h = B u; ÿ = −k_p y − k_d ẏ with the s̈ that q̈ gives; the gait's effort of the ankle."""
    plan, config = one(gait)[0], settings()
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
    run = _Steps(loop(), plan, plan.constraints(config))
    found = run._derivative(phase, np.c_[q, v, 0.0])[0, NUM : 2 * NUM] * speed
    turn = 0.0
    if gait == HIP:
        turn = (float(slope[0] @ found + bend[0]) - hip_bend * speed**2) / hip_slope
    desired, first, second = (order[0] for order in motion(plan, phase, config))
    rows = np.delete(output_matrix(GEOMETRY), YAW, axis=1)
    y, y_rate = rows @ (q[0] - desired), rows @ (v[0] - first * speed)
    missed = rows @ (found - second * speed**2 - first * turn) + config.kp * y + config.kd * y_rate
    mass, bias = model.symbols.dynamics(q[0], v[0])
    efforts = mass.full() @ found + bias.full()[:, 0]
    kept = np.ones(10, bool)
    kept[ANKLE] = False
    np.testing.assert_allclose(missed[kept], 0.0, atol=1e-4)
    np.testing.assert_allclose(efforts[0], 0.0, atol=1e-4)
    np.testing.assert_allclose(efforts[1 + ANKLE], plan.ankle.at(phase)[0][0, 0], atol=1e-4)


@both
def test_the_walk_returns_to_its_points(gait):
    cycle = points()[:, gait]
    for step in range(2):
        flow = loop().step(one(gait)[step], cycle[step][None])
        np.testing.assert_allclose(flow.after_impact.state[0], cycle[1 - step], atol=1e-8)
        seen = coordinates(loop().model.measure(flow.q[10], flow.v[10]))
        np.testing.assert_allclose(zero(gait).orbit[step, 0, 10], seen, atol=1e-8)


def regulator(gait: int) -> Regulator:
    return regulate(zero(gait), 0, settings().feedback)


def displacement(gait: int, step: int, x: np.ndarray) -> np.ndarray:
    """b = −K Z (x − x*) (n, 2) of states (n, 22) at the start of a step."""
    error = (x - points()[step, gait]) @ whole(gait).projection[step].T
    return -error @ regulator(gait).gains[step].T


@both
def test_the_return_map_has_the_rank_and_the_multipliers_of_the_zero_dynamics(gait):
    """22 columns of its derivative, from section to section, against the few that count."""
    found, maps = whole(gait), zero(gait).maps[:, 0]
    rank = 4 if gait == CLOCK else 3
    for derivative in found.derivatives:
        values = np.linalg.svd(derivative, compute_uv=False)
        assert values[rank] < 1e-3 * values[0]
    assert maps.shape == (2, rank, rank)
    executed = np.abs(multipliers(found.derivatives))[:rank]
    np.testing.assert_allclose(np.abs(multipliers(maps)), executed, atol=1e-4)
    np.testing.assert_allclose(regulator(gait).multipliers[0] ** 2, executed, atol=1e-4)
    # Z x is where x is on the zero dynamics: Z⁺ DP = A Z, Z⁺ ∂P/∂b = B.
    after = found.projection[::-1]
    np.testing.assert_allclose(after @ found.derivatives, maps @ found.projection, atol=2e-3)
    np.testing.assert_allclose(after @ found.placements, zero(gait).inputs[:, 0], atol=1e-4)


@both
def test_foot_placement_stabilises_the_executed_walk(gait):
    """The closed loop's own differences have the eigenvalues of A − B K."""
    found = regulator(gait)
    assert found.multipliers[0, 0] > 2.0**0.5
    executed = []
    for step, plan in enumerate(one(gait)):

        def walked(x, rows, step=step, plan=plan):
            return loop().step(take(plan, rows), x, displacement(gait, step, x)).after_impact.state

        executed.append(differences(walked, points()[step, [gait]], 1e-5)[1][0])
    expected = found.multipliers[1, 0] ** 2
    assert expected < 0.6
    np.testing.assert_allclose(np.abs(multipliers(executed)[0]), expected, atol=2e-3)


@both
def test_gains_over_the_phase_ask_for_the_same_step(gait):
    """A perturbed walk whose foot is displaced by b measures ξ(s) with b = −K(s) (ξ − ξ*)."""
    plan, gains, size = one(gait)[0], regulator(gait).phase_gains, 1e-4
    rows = np.delete(output_matrix(GEOMETRY), YAW, axis=1)
    turn = np.linalg.svd(rows)[2][-1]
    x = points()[0, gait] + size * np.r_[turn, 3.0 * turn]
    b = displacement(gait, 0, x[None])
    flow = loop().step(plan, x[None], b)
    for k in (0, 10, 14, 20):
        seen = coordinates(loop().model.measure(flow.q[k], flow.v[k]))
        expected = -gains[0, k] @ (seen - zero(gait).orbit[0, 0, k])
        np.testing.assert_allclose(expected, b[0], rtol=0.02, atol=1e-2 * np.abs(b).max())
    assert not gains[..., 3].any() or gait == CLOCK
