"""Random numbers are functions of seed, use and time, in both libraries."""

from typing import Any

import numpy as np
import pytest
import torch

from slider.env.disturbance import NOISE, PUSH, Draws
from slider.env.starts import NUMPY

TORCH: Any = torch.zeros(0)


@pytest.mark.parametrize("kind", ["uniform", "normal"])
@pytest.mark.parametrize("like", [NUMPY, TORCH], ids=["numpy", "torch"])
def test_a_block_of_robots_depends_on_its_own_seed_use_and_time_only(like, kind):
    def draw(seeds: tuple[int, ...], count: int, use: int = PUSH, time: int = 7) -> np.ndarray:
        values = getattr(Draws(seeds, count, like), kind)(use, time, 4)
        assert values.dtype == like.dtype
        return np.array(values)

    both = draw((1, 2), 6)
    np.testing.assert_array_equal(both[3:], draw((2,), 3))
    np.testing.assert_array_equal(both, draw((1, 2), 6))
    others = draw((1,), 3), draw((2,), 3, time=8), draw((2,), 3, use=NOISE)
    assert all((both[3:] != other).all() for other in others)


@pytest.mark.parametrize("like", [NUMPY, TORCH], ids=["numpy", "torch"])
def test_distributions(like):
    draws = Draws((3,), 4000, like)
    uniform, normal = (
        np.array(values) for values in (draws.uniform(0, 0, 1), draws.normal(0, 0, 1))
    )
    assert 0.0 <= uniform.min() < 0.01 < 0.99 < uniform.max() < 1.0
    assert uniform.mean() == pytest.approx(0.5, abs=0.02)
    assert normal.mean() == pytest.approx(0.0, abs=0.05)
    assert normal.std() == pytest.approx(1.0, abs=0.05)


def test_blocks_are_of_one_size():
    with pytest.raises(ValueError, match=r"^expected 5 robots in 2 blocks of the same size$"):
        Draws((1, 2), 5)
