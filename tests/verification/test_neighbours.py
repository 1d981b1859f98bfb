"""Mirrored and neighbouring gaits."""

from dataclasses import replace

import numpy as np
import pytest

from slider.verification.neighbours import jumps_of, mirror, neighbours, reflected, smoothness
from tests.verification.sample import gaits, turning_gaits


def test_reflection_is_its_own_inverse_and_changes_the_feet():
    samples = gaits()[1].samples
    np.testing.assert_array_equal(reflected(reflected(samples)), samples)
    assert np.abs(reflected(samples) - samples).max() > 0.01


def test_the_reflection_of_a_gait_is_its_partner():
    gait = gaits()[1]
    image = replace(
        gait, samples=reflected(gait.samples), commands=gait.commands * [1.0, -1.0, -1.0]
    )
    found = mirror([gait, image])
    assert found[0] == found[1] == {"mirror_distance": 0.0, "mirror_cost": 0.0}


def test_solved_partners_are_reflections_of_each_other():
    found = mirror(gaits())
    assert found[0]["mirror_cost"] < 1e-8
    assert 0 < found[0]["mirror_distance"] < 1e-4
    assert found[0] == found[1]
    assert found[2] == {}  # no partner in this library
    turning = mirror(turning_gaits())
    assert turning[0] == turning[1]
    assert turning[0]["mirror_cost"] < 1e-8
    assert 0 < turning[0]["mirror_distance"] < 1e-4


def test_neighbours_differ_in_one_component_and_have_none_between():
    commands = np.zeros((6, 3))
    commands[:5, 0] = [0.0, 0.05, 0.1, 0.3, 0.05]
    commands[4, 1], commands[5, 2] = 0.05, 0.1
    assert sorted(neighbours(commands, 0.1)) == [(0, 1), (0, 5), (1, 2), (1, 4)]
    assert (2, 3) in neighbours(commands, 0.2)


def test_a_jump_is_a_share_of_the_range_per_step_of_the_grid():
    gait = gaits()[1]
    flat = replace(gait, samples=np.zeros_like(gait.samples))

    def at(vx, hip):
        samples = flat.samples.copy()
        samples[:, 2] = hip
        return replace(flat, samples=samples, commands=np.array([vx, 0.0, 0.0]))

    pairs = smoothness([at(0.0, 0.0), at(0.05, 0.1), at(0.15, 0.4)], 0.1)
    assert [pair.samples for pair in pairs] == [pytest.approx(0.25), pytest.approx(0.375)]
    assert jumps_of(pairs, 1)["jump_samples"] == pytest.approx(0.375)
    assert jumps_of(pairs, 5) == {}


def test_solved_neighbours_are_near():
    pair = smoothness(gaits(), 0.1)[0]
    assert (pair.first, pair.second) == (1, 2)
    assert 0.1 < pair.samples < 0.3
    assert 0.05 < pair.coefficients < 0.2
