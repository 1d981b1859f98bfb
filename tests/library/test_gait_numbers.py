"""The variance within a gait and its step rate, against closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from slider.library.blend import gait_numbers
from slider.library.reader import GaitLibrary
from tests.library.gaits import HALF, library


@pytest.fixture(scope="module")
def gaits(tmp_path_factory) -> GaitLibrary:
    return library(tmp_path_factory.mktemp("numbers"), [(0.0, 0.0), (1.0, 0.0)])


def with_speed(gaits: GaitLibrary, speed: np.ndarray, times: list[float]) -> GaitLibrary:
    """The same two gaits with forward velocities (2, 42) and step times."""
    samples = gaits.arrays["samples"].copy()
    samples[..., 24] = speed
    step_time = np.tile(times, (2, 1))
    return replace(gaits, arrays={**gaits.arrays, "samples": samples, "step_time": step_time})


def test_a_sine_has_half_of_its_squared_amplitude(gaits):
    step = 0.7 + 0.2 * np.sin(2 * np.pi * np.linspace(0, 1, HALF))
    swaying = with_speed(gaits, np.tile(step, (2, 2)), [0.4, 0.4])
    assert forward_variance(swaying, 1.0) == pytest.approx(0.02, rel=1e-6)


def test_a_longer_step_counts_more(gaits):
    """Speeds 1 and 2 for 0.3 s and 0.1 s: mean 1.25, variance 0.75 · 0.25² + 0.25 · 0.75²."""
    speed = np.repeat([1.0, 2.0], HALF)
    found = forward_variance(with_speed(gaits, np.tile(speed, (2, 1)), [0.3, 0.1]), 0.0)
    assert found == pytest.approx(0.75 * 0.25**2 + 0.25 * 0.75**2)


def test_between_gaits_the_speeds_are_blended(gaits):
    wave = np.tile(np.sin(2 * np.pi * np.linspace(0, 1, HALF)), 2)
    swaying = with_speed(gaits, np.stack([0.0 * wave, 0.2 * wave]), [0.4, 0.4])
    assert forward_variance(swaying, 0.5) == pytest.approx(0.005, rel=1e-6)


def test_there_is_one_touchdown_per_step(gaits):
    """Steps of 0.3 s and 0.5 s: two touchdowns in 0.8 s."""
    found = gait_numbers(with_speed(gaits, np.ones((2, 2 * HALF)), [0.3, 0.5]), 0.5)
    assert found is not None
    assert found.touchdown_rate == pytest.approx(2 / 0.8)


@pytest.mark.parametrize("vx", [-0.1, 1.1])
def test_no_gait_no_number(gaits, vx):
    assert gait_numbers(gaits, vx) is None
    assert gait_numbers(gaits, 1.0) is not None


def forward_variance(gaits: GaitLibrary, vx: float) -> float:
    found = gait_numbers(gaits, vx)
    assert found is not None
    return found.velocity_variance
