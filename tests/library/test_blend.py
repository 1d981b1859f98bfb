"""Blended gaits: exact at the library's velocities, continuous between them, and their numbers."""

from dataclasses import replace

import numpy as np
import pytest

from slider.library.blend import blend, gait_statistics
from slider.library.reader import STORE, GaitLibrary
from tests.library.gaits import HALF, library
from tests.library.solved import solved_library

PHASE = np.linspace(0.0, 1.0, 21)


@pytest.fixture(scope="module")
def real() -> GaitLibrary:
    """Two solved gaits that are no mirror images of themselves."""
    return GaitLibrary.load(solved_library(((0.6, 0.1, 0.0), (0.65, 0.1, 0.0))) / STORE)


def test_a_real_gait_comes_back_from_its_polynomials(real):
    for index, velocity in enumerate(real.velocities):
        gait = blend(real, *velocity)
        np.testing.assert_allclose(gait.samples(), real.arrays["samples"][index], atol=1e-9)
        for name in ("step_time", "coefficients", "roll", "base"):
            np.testing.assert_allclose(getattr(gait, name), real.arrays[name][index], atol=1e-12)
        for name, column in (("knee_positions", 0), ("knee_velocities", 1)):
            steps = [gait.knee_joints(step, PHASE)[column] for step in range(2)]
            np.testing.assert_allclose(np.concatenate(steps), real.arrays[name][index], atol=1e-9)


def test_velocities_of_a_blend_are_the_derivatives_of_its_positions(real):
    gait = blend(real, 0.62, 0.1)
    assert gait.weights == pytest.approx([0.6, 0.4])
    for step in range(2):
        phase, small = np.linspace(0.05, 0.95, 11), 1e-5
        position, velocity = gait.joints(step, phase)
        after, before = (gait.joints(step, phase + s)[0] for s in (small, -small))
        slope = (after - before) / (2 * small * gait.step_time[step])
        np.testing.assert_allclose(velocity, slope, atol=1e-6)
        assert np.abs(velocity).max() > 0.5
        assert not position[:, [5, 11]].any()  # the upper feet


@pytest.fixture(scope="module")
def gaits(tmp_path_factory) -> GaitLibrary:
    return library(tmp_path_factory.mktemp("numbers"), [(0.0, 0.0), (1.0, 0.0)])


def test_a_longer_step_counts_more_and_each_step_has_a_touchdown(gaits):
    """Speeds 1 and 2 for 0.3 s and 0.1 s: mean 1.25, variance 0.75 · 0.25² + 0.25 · 0.75²."""
    samples = gaits.arrays["samples"].copy()
    samples[..., 24] = np.repeat([1.0, 2.0], HALF)
    changed = {"samples": samples, "step_time": np.tile([0.3, 0.1], (2, 1))}
    found = gait_statistics(replace(gaits, arrays={**gaits.arrays, **changed}), 0.5)
    assert found.velocity_variance == pytest.approx(0.75 * 0.25**2 + 0.25 * 0.75**2)
    assert found.touchdown_rate == pytest.approx(2 / 0.4)
    assert [gait_statistics(gaits, vx) is None for vx in (-0.1, 1.0, 1.1)] == [True, False, True]
