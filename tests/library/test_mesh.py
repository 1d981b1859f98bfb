"""The weights of gaits over the velocity."""

from itertools import product

import numpy as np
import pytest

from slider.library.mesh import VelocityMesh

VX, VY = (0.0, 0.05, 0.1, 0.15), (-0.1, 0.0, 0.1)
GRID = np.array([*product(VX, VY, (0.0,))])
WITHOUT_ONE = GRID[[tuple(v) != (0.05, 0.0, 0.0) for v in GRID]]
YAW = (-0.3, 0.0, 0.3)
TURNING = np.array([*product(VX, VY, YAW)])
# A block with other velocities in vy, as the extended grid has, and a corner that is missing.
BLOCKS = np.array([*product(VX, VY, (0.0,)), (0.25, -0.1, 0.0), (0.25, 0.1, 0.0), (0.35, 0.1, 0.0)])
MESHES = pytest.mark.parametrize(
    "velocities", [GRID, WITHOUT_ONE, BLOCKS, GRID[:1], GRID[1::3], TURNING, TURNING[::2]]
)


def weights(velocities: np.ndarray, vx: float, vy: float, yaw_rate: float = 0.0) -> np.ndarray:
    return VelocityMesh.of(velocities).weights(np.array([[vx, vy, yaw_rate]]))[0]


def linear(velocities: np.ndarray) -> np.ndarray:
    return 3.0 + velocities @ [-2.0, 5.0, 1.5]


@MESHES
def test_a_gait_s_own_velocity_takes_that_gait_alone(velocities):
    for index, velocity in enumerate(velocities):
        expected = np.eye(len(velocities))[index]
        np.testing.assert_allclose(weights(velocities, *velocity), expected, atol=1e-12)


@MESHES
def test_weights_are_shares(velocities):
    rng = np.random.default_rng(0)
    asked = rng.uniform((-0.2, -0.3, -0.5), (0.6, 0.3, 0.5), (300, 3))
    found = VelocityMesh.of(velocities).weights(asked)
    assert (found >= 0).all()
    np.testing.assert_allclose(found.sum(axis=1), 1.0, atol=1e-12)


def test_a_hole_between_gaits_is_filled_linearly():
    assert weights(WITHOUT_ONE, 0.05, 0.0) @ linear(WITHOUT_ONE) == pytest.approx(2.9)
    used = WITHOUT_ONE[weights(WITHOUT_ONE, 0.05, 0.0) > 0]
    assert {tuple(v) for v in used[:, :2]} == {(0.0, 0.0), (0.1, 0.0), (0.05, -0.1), (0.05, 0.1)}


def test_a_complete_cell_with_a_yaw_rate_is_trilinear():
    """A product of three linear functions is reproduced, and it is that of the eight corners."""
    rng = np.random.default_rng(2)
    asked = rng.uniform((0.0, -0.1, -0.3), (0.05, 0.0, 0.0), (50, 3))
    mesh = VelocityMesh.of(TURNING)
    for function in (linear, lambda c: (1 + c[:, 0]) * (2 - c[:, 1]) * (3 + c[:, 2])):
        found = mesh.weights(asked) @ function(TURNING)
        np.testing.assert_allclose(found, function(asked), atol=1e-12)
    assert ((mesh.weights(asked) > 0).sum(axis=1) == 8).all()


def test_the_nearer_pair_counts_more():
    velocities = np.zeros((5, 3))
    velocities[:, :2] = [(0.0, 0.0), (1.0, 0.1), (1.0, -0.1), (3.0, 0.0), (2.0, 0.1)]
    found = weights(velocities, 1.0, 0.0)  # (0, 0) and (3, 0) are 3 places apart, the others 2
    np.testing.assert_allclose(found, [0.4 * 2 / 3, 0.3, 0.3, 0.4 / 3, 0.0])


def test_a_node_between_no_gaits_is_the_nearest_one():
    found = weights(BLOCKS, 0.35, -0.1)
    assert BLOCKS[found.argmax()].tolist() == [0.25, -0.1, 0.0]
    assert found.max() == 1.0


def test_velocities_outside_take_the_border():
    np.testing.assert_array_equal(weights(GRID, 9.0, 0.03), weights(GRID, 0.15, 0.03))
    np.testing.assert_array_equal(weights(GRID, 0.07, -9.0), weights(GRID, 0.07, -0.1))


@pytest.mark.parametrize("velocities", [GRID, WITHOUT_ONE, BLOCKS, TURNING])
def test_weights_are_continuous(velocities):
    """No weight changes faster than trilinear weights can: one cell per jump of one."""
    rng = np.random.default_rng(1)
    start = rng.uniform((-0.1, -0.2, -0.5), (0.5, 0.2, 0.5), (2000, 3))
    step = 1e-4 * rng.uniform(-1, 1, start.shape)
    mesh = VelocityMesh.of(velocities)
    change = mesh.weights(start + step) - mesh.weights(start)
    assert np.abs(change).sum(axis=1).max() < 2.1 * 1e-4 * (1 / 0.05 + 1 / 0.1 + 1 / 0.3)
