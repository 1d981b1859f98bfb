"""Gaits over the range of commands: they converge, walk, and change smoothly."""

import numpy as np
import pytest

from tests.gait.gaits import config, problem, solved, trajectory

COMMANDS = [(0.0, 0.0), (0.4, -0.1), (1.2, 0.0), (2.2, 0.1)]


@pytest.mark.parametrize("command", COMMANDS)
def test_cold_starts_converge(command):
    solve = solved(*command)
    assert solve.success, solve.status
    assert solve.max_violation <= 1e-6
    assert solve.iterations < 60


@pytest.mark.parametrize("command", COMMANDS)
def test_the_swing_foot_clears_the_ground_and_stays_low(command):
    posture, half = config().gait.posture, problem().nodes
    height = trajectory(*command).swing_foot[:, 2].reshape(2, half)
    assert (height.max(axis=1) >= posture.clearance - 1e-6).all()
    assert (height <= posture.swing_height + 1e-6).all()


def test_neighbouring_velocities_give_neighbouring_gaits():
    for command, neighbour, most in (
        ((0.0, 0.0), (0.05, 0.0), 0.25),  # walking in place leaves the legs a choice
        ((0.4, -0.1), (0.4, -0.05), 0.05),
    ):
        first, second = trajectory(*command), trajectory(*neighbour)
        assert np.abs(first.q - second.q).max() < most


def test_a_walk_in_place_is_symmetric():
    steps = solved(0.0, 0.0).variables.reshape(2, -1)
    np.testing.assert_allclose(steps[0], steps[1], atol=1e-5)
