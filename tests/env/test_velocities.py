"""Commands stay in their ranges and change at their rate."""

import numpy as np
import pytest
import torch

from slider.config.train import CurriculumConfig, VelocitiesConfig
from slider.config.types import Interval
from slider.env.interface import FLOAT64
from slider.env.velocities import Curriculum, Random, VelocitySampler

COUNT = 20000


@pytest.fixture
def rng() -> Random:
    return Random(0, FLOAT64)


def sampler(period: float = 5.0, standing: float = 0.25) -> VelocitySampler:
    ranges = (Interval(0.2, 3.0), Interval(-0.1, 0.3), Interval(-0.5, 0.5))
    curriculum = CurriculumConfig(1.0, 0.1, 0.9)
    config = VelocitiesConfig(*ranges, period, standing, curriculum, uneven=1.0)
    return VelocitySampler(config, control_period=0.02, like=FLOAT64)


def test_uniform_within_the_ranges(rng):
    commands = sampler(standing=0.0).sample(rng, COUNT).numpy()
    assert commands.shape == (COUNT, 3)
    lower, upper = np.array([0.2, -0.1, -0.5]), np.array([3.0, 0.3, 0.5])
    assert (commands >= lower).all()
    assert (commands <= upper).all()
    width = upper - lower
    np.testing.assert_allclose(commands.mean(axis=0), (lower + upper) / 2, atol=0.01 * width.max())
    np.testing.assert_allclose(commands.std(axis=0), width / np.sqrt(12), rtol=0.02)
    assert np.abs(np.corrcoef(commands.T) - np.eye(3)).max() < 0.03


def test_rate_of_change(rng):
    changing = sampler(period=4.0).changing
    counts = np.zeros(500)
    for _ in range(1000):  # 20 s: five changes per robot on average
        counts[changing(rng, 500)] += 1
    assert counts.mean() == pytest.approx(5.0, rel=0.05)
    assert counts.var() == pytest.approx(5.0, rel=0.25), "robots should change independently"


def test_period_zero_never_changes(rng):
    changed = [sampler(period=0.0).changing(rng, COUNT) for _ in range(5)]
    assert sum(len(index) for index in changed) == 0


def test_a_share_of_the_ranges_about_zero(rng):
    commands = sampler(standing=0.0).sample(rng, COUNT, share=0.5).numpy()
    assert commands.min(axis=0) == pytest.approx([0.1, -0.05, -0.25], abs=0.01)
    assert commands.max(axis=0) == pytest.approx([1.5, 0.15, 0.25], abs=0.01)


def test_the_share_grows_with_success_only():
    curriculum = Curriculum(
        CurriculumConfig(start=0.4, growth=0.35, success=0.9), window=10, like=FLOAT64
    )

    def note(ended: int, fallen: int) -> float:
        robots = torch.arange(10)
        curriculum.note(robots < ended, robots < fallen)
        return curriculum.share.item()

    assert note(ended=9, fallen=0) == 0.4, "the window is not full"
    assert note(ended=1, fallen=1) == pytest.approx(0.75)
    assert note(ended=10, fallen=2) == pytest.approx(0.75)
    assert note(ended=10, fallen=0) == 1.0
    assert note(ended=10, fallen=0) == 1.0
