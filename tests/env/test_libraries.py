"""Every term gives the same numbers on NumPy arrays and on torch tensors, and asks no device."""

from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np
import pytest
import torch
from torch.utils._python_dispatch import TorchDispatchMode

from slider.core.arrays import asarray, beside
from slider.env import observations, rewards, terminations
from slider.env.guide import Guide
from slider.env.rewards import RewardView
from tests.env.synthetic import config, gait_table, library
from tests.env.test_rewards import moving_view
from tests.env.test_terms import PARAMS

LIKE: Any = torch.zeros(0, dtype=torch.float64)
VIEW = replace(moving_view(), halted=np.arange(40) % 5 == 0)
TERMINATIONS = config("experiment=test").env.termination.terms
# Reading a value on the host, and shapes that depend on values.
WAITS = ("_local_scalar_dense", "nonzero", "masked_select")


class NoWaiting(TorchDispatchMode):
    """Fails where a device would be waited for."""

    def __torch_dispatch__(self, func, types, args=(), kwargs=None):
        if any(name in str(func) for name in WAITS):
            raise AssertionError(f"waits for the device: {func}")
        return func(*args, **(kwargs or {}))


def both(on_numpy: Any, compute: Any, tolerance: float = 1e-12) -> None:
    """Compare ``compute`` of both libraries; torch's second call has all its constants."""
    on_torch = beside(on_numpy, LIKE)
    compute(on_torch)
    with NoWaiting():
        found = compute(on_torch)
    expected = compute(on_numpy)
    np.testing.assert_allclose(found.numpy(), expected, rtol=tolerance, atol=tolerance)


def guide(view: Any, gait: str) -> Guide:
    return Guide(library(), beside(gait_table(), view.phase), gait)


@pytest.mark.parametrize("name", observations.TERMS)
def test_observation(name):
    both(VIEW, observations.TERMS[name].function)


@pytest.mark.parametrize("gait", ["interpolated", "nearest"])
@pytest.mark.parametrize("name", rewards.TERMS)
def test_reward(name, gait):
    guides = {type(view.phase): guide(view, gait) for view in (VIEW, beside(VIEW, LIKE))}
    before = np.random.default_rng(0).standard_normal((40, 2, 10))

    def compute(view):
        seen = RewardView(view, guides[type(view.phase)], asarray(before, view.phase))
        return rewards.TERMS[name].function(seen, **PARAMS.get(name, {}))

    # Distances to samples are in float32 by design.
    both(VIEW, compute, 1e-6 if name == "guide_nearest" else 1e-12)


@pytest.mark.parametrize("name", terminations.TERMS)
def test_termination(name):
    both(VIEW.state, lambda s: terminations.TERMS[name].function(s, TERMINATIONS.get(name, 0.5)))


def test_the_views_hold_arrays_of_one_library():
    def arrays(batch: Any):
        for field in fields(batch):
            value = getattr(batch, field.name)
            yield from arrays(value) if is_dataclass(value) else [value]

    assert not any(isinstance(value, np.ndarray) for value in arrays(beside(VIEW, LIKE)))
