"""Commands stay in their ranges and change at their rate."""

import numpy as np
import pytest

from slider.config.train import VelocitiesConfig
from slider.config.types import Interval
from slider.env.interface import FLOAT64
from slider.env.velocities import Random, VelocitySampler

COUNT = 20000


@pytest.fixture
def rng() -> Random:
    return Random(0, FLOAT64)


def sampler(period: float = 5.0, standing: float = 0.25) -> VelocitySampler:
    ranges = (Interval(0.2, 3.0), Interval(-0.1, 0.3), Interval(-0.5, 0.5))
    config = VelocitiesConfig(*ranges, period, standing, uneven=1.0)
    return VelocitySampler(config, control_period=0.02, like=FLOAT64)


def test_uniform_within_the_ranges(rng):
    commands = sampler(standing=0.0).sample(rng, COUNT).numpy()
    lower, upper = np.array([[0.2, -0.1, -0.5], [3.0, 0.3, 0.5]])
    assert ((commands >= lower) & (commands <= upper)).all()
    width = upper - lower
    np.testing.assert_allclose(commands.mean(axis=0), (lower + upper) / 2, atol=0.01 * width.max())
    np.testing.assert_allclose(commands.std(axis=0), width / np.sqrt(12), rtol=0.02)
    assert np.abs(np.corrcoef(commands.T) - np.eye(3)).max() < 0.03


@pytest.mark.parametrize(("period", "expected"), [(4.0, 5.0), (0.0, 0.0)])
def test_rate_of_change(rng, period, expected):
    """In 20 s; never, at a period of zero."""
    changing, counts = sampler(period).changing, np.zeros(500)
    for _ in range(1000):
        counts[changing(rng, 500)] += 1
    assert counts.mean() == pytest.approx(expected, rel=0.05)
    assert counts.var() == pytest.approx(expected, rel=0.25), "robots should change independently"
