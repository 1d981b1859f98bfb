"""The periodic regulator against the Riccati recursion."""

import numpy as np
import pytest

from slider.config.hzd import FootPlacementConfig
from slider.core.errors import UserError
from slider.hzd.regulator import periodic_lqr, regulate
from slider.hzd.walk import ZeroDynamics


def test_a_cycle_of_two_has_the_gains_of_the_recursion():
    rng = np.random.default_rng(1)
    a, b = 1.5 * rng.standard_normal((2, 3, 3)), rng.standard_normal((2, 3, 2))
    q, r = np.diag([2.0, 1.0, 0.5]), np.diag([1.0, 3.0])
    cost, expected = q, {}
    for step in [1, 0] * 200:
        gain = np.linalg.solve(r + b[step].T @ cost @ b[step], b[step].T @ cost @ a[step])
        cost = q + a[step].T @ cost @ (a[step] - b[step] @ gain)
        expected[step] = gain
    found = periodic_lqr(a, b, q, r)
    np.testing.assert_allclose(found, [expected[0], expected[1]], rtol=1e-8, atol=1e-10)
    closed = (a[1] - b[1] @ found[1]) @ (a[0] - b[0] @ found[0])
    assert np.abs(np.linalg.eigvals(closed)).max() < 1.0


def coupled(lateral_to_forward: float, forward_to_lateral: float) -> ZeroDynamics:
    """A walk of (c_y, ċ_y, ċ_x) whose foot moves each direction's own coordinates at once."""
    maps = np.diag([1.5, 0.5, 1.2])
    maps[2, 0], maps[0, 2] = lateral_to_forward, forward_to_lateral
    inputs = np.array([[0.0, 1.0], [0.0, 0.0], [1.0, 0.0]])
    whole, moved = np.tile(np.eye(3), (2, 1, 5, 1, 1)), np.tile(inputs, (2, 1, 5, 1, 1))
    maps, inputs = np.tile(maps, (2, 1, 1, 1)), np.tile(inputs, (2, 1, 1, 1))
    return ZeroDynamics(np.zeros((2, 1, 5, 4)), maps, inputs, whole, moved, np.zeros((2, 1, 22, 3)))


WEIGHTS = FootPlacementConfig(position=10.0, velocity=1.0, displacement=1.0, reach=0.25)


def test_each_direction_answers_its_own_coordinates():
    found = regulate(coupled(0.0, 0.0), 0, WEIGHTS)
    assert not found.gains[:, 0, :2].any()
    assert not found.gains[:, 1, 2].any()
    closed = np.diag([1.5, 0.5, 1.2]) - coupled(0.0, 0.0).inputs[0, 0] @ found.gains[0]
    assert np.abs(np.linalg.eigvals(closed)).max() < 1.0
    lateral = found.gains[:, 1, 0]
    np.testing.assert_allclose(found.phase_gains[:, 2, 1, 0], lateral / (1 - lateral))


def test_a_coupling_that_undoes_both_regulators_gets_a_joint_one():
    """Closed alone they have 0.11 and 0.41: (x − 0.11)(x − 0.41) = 1.3 has a root of 1.41."""
    walk = coupled(1.0, 1.3)
    found = regulate(walk, 0, WEIGHTS)
    assert found.multipliers[1, 0] < 1.0 < found.multipliers[0, 0]
    assert found.gains[0, [0, 1], [0, 2]].all(), "each answers the other's"
    closed = walk.maps[0, 0] - walk.inputs[0, 0] @ found.gains[0]
    moduli = np.sort(np.abs(np.linalg.eigvals(closed @ closed)))[::-1] ** 0.5
    np.testing.assert_allclose(found.multipliers[1], moduli)


@pytest.mark.parametrize("inputs", [[[0.0, 0.0]] * 3, [[0.0, 1.0], [0.0, 0.0], [0.0, 0.0]]])
def test_what_cannot_be_stabilised_is_one_line(inputs):
    walk = coupled(0.0, 0.0)
    walk.inputs[:] = inputs
    with pytest.raises(UserError, match="foot placement stabilises"):
        regulate(walk, 0, WEIGHTS)


def test_a_joint_regulator_takes_over_where_a_direction_alone_has_none():
    """The foot moves forward velocity by its leftward displacement only."""
    walk = coupled(0.0, 0.0)
    walk.inputs[:] = [[1.0, 0.0], [0.0, 0.0], [0.0, 1.0]]
    assert regulate(walk, 0, WEIGHTS).multipliers[1, 0] < 1.0
