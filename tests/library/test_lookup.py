"""Looking gaits up by velocity and phase."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from slider.library.lookup import GaitTable
from slider.library.reader import GaitLibrary
from tests.library.gaits import HALF, value, write_store

VELOCITIES = [*product((0.0, 0.5, 1.0), (-0.1, 0.0, 0.1)), (2.0, 0.0)]


@pytest.fixture(scope="module")
def library(tmp_path_factory) -> GaitLibrary:
    folder = tmp_path_factory.mktemp("library")
    return GaitLibrary.load(write_store(folder, VELOCITIES))


@pytest.fixture(scope="module")
def table(library) -> GaitTable:
    return GaitTable.from_library(library)


def look_up(table: GaitTable, vx: float, vy: float, phase: float) -> np.ndarray:
    return table.at(np.array([[vx, vy, 0.0]]), np.array([phase]))[0]


@pytest.mark.parametrize("velocity", [(0.0, 0.0), (0.5, 0.1), (1.0, -0.1), (2.0, 0.0)])
@pytest.mark.parametrize("sample", [0, 7, 19, 21, 30, 40])
def test_samples_of_the_library_come_back(table, velocity, sample):
    step, node = divmod(sample, HALF)
    phase = step / 2 + node / (HALF - 1) / 2
    found = look_up(table, *velocity, phase)
    np.testing.assert_allclose(found[:26], value("samples", *velocity)[sample], atol=1e-9)
    np.testing.assert_allclose(found[26:29], value("base", *velocity)[sample, :3], atol=1e-9)


def test_between_gaits_it_is_linear(table):
    found = look_up(table, 0.73, 0.04, 0.0)
    np.testing.assert_allclose(found[:26], value("samples", 0.73, 0.04)[0], atol=1e-9)
    times = table.times.at(np.array([[0.73, 0.04, 0.0], [1.5, 0.0, 0.0]]))
    np.testing.assert_allclose(times, 0.42 - 0.05 * np.array([0.73, 1.5]), atol=1e-9)


def test_quaternions_are_unit_and_do_not_cancel(library):
    flipped = library.arrays["base"].copy()
    flipped[::2, :, 3:7] *= -1  # q and −q are the same attitude
    other = replace(library, arrays={**library.arrays, "base": flipped})
    rng = np.random.default_rng(0)
    velocities = rng.uniform((0, -0.1, -0.3), (2, 0.1, 0.3), (100, 3))
    found = GaitTable.from_library(other).at(velocities, rng.uniform(0, 1, 100))[:, 29:33]
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1, atol=1e-12)
    assert (np.abs(found[:, 0]) > 0.99).all()


def test_standing_is_between_the_two_changes_of_feet_and_at_rest(table):
    found, zero = table.standing, np.zeros((2, 3))
    changes = table.at(zero, np.array([0.0, 0.5]))
    np.testing.assert_allclose(found[:12], changes[:, :12].mean(axis=0), atol=1e-12)
    np.testing.assert_allclose(found[26:29], changes[:, 26:29].mean(axis=0), atol=1e-12)
    np.testing.assert_array_equal(found[12:26], 0.0)
    np.testing.assert_array_equal(found[33:], 0.0)
    np.testing.assert_allclose(np.linalg.norm(found[29:33]), 1.0)
    np.testing.assert_array_equal(table.joints.standing, found[:12])
    assert table.at(zero, np.zeros(2))[0, 12:26].any(), "a gait moves"
