"""Jumps between neighbouring gaits."""

import numpy as np
import pytest

from slider.library.measures import neighbours, smoothness

COMMANDS = np.array(
    [(0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.3, 0.0, 0.0), (0.1, 0.1, 0.0), (0.0, -0.1, 0.0)]
)


def test_neighbours_follow_one_another_in_a_row_or_a_column():
    found = {tuple(sorted(pair)) for pair in neighbours(COMMANDS).tolist()}
    assert found == {(0, 1), (1, 2), (1, 3), (0, 4)}


def test_gaits_of_other_yaw_rates_are_neighbours_at_one_velocity_only():
    turned = COMMANDS[[0, 1]] + [0.0, 0.0, 0.3]
    found = neighbours(np.concatenate([COMMANDS, turned, COMMANDS[:1] + [0.0, 0.0, 0.6]]))
    found = {tuple(sorted(pair)) for pair in found.tolist()}
    assert found == {(0, 1), (1, 2), (1, 3), (0, 4), (5, 6), (0, 5), (1, 6), (5, 7)}


def test_jumps_are_shares_of_each_channel_s_range():
    samples = np.zeros((5, 3, 2))
    samples[:, :, 0] = np.array([0.0, 1.0, 10.0, 2.0, 0.0])[:, None]  # range 10
    samples[2, 1, 1] = -0.5  # range 0.5, one sample of one gait
    measured = smoothness(COMMANDS, samples)
    jumps = {
        tuple(sorted(p)): j for p, j in zip(measured.pairs.tolist(), measured.jumps, strict=True)
    }
    np.testing.assert_allclose(jumps[0, 1], [0.1, 0.0])
    np.testing.assert_allclose(jumps[1, 2], [0.9, 1.0])
    np.testing.assert_allclose(jumps[1, 3], [0.1, 0.0])
    assert measured.largest == 1.0
    assert sorted(measured.worst[:2]) == [1, 2]
    assert measured.worst[2] == 1
    np.testing.assert_allclose(measured.per_gait(5), [0.1, 1.0, 1.0, 0.1, 0.0])


def test_a_constant_channel_has_no_jump_and_a_single_gait_no_neighbour():
    assert smoothness(COMMANDS, np.ones((5, 3, 2))).largest == 0.0
    alone = smoothness(COMMANDS[:1], np.ones((1, 3, 2)))
    assert alone.largest == 0.0
    assert alone.per_gait(1).tolist() == [0.0]
    with pytest.raises(ValueError, match="expected at least two neighbouring gaits, found none"):
        _ = alone.worst
