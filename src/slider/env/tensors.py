"""Torch beside the environment's arrays, be they of NumPy or tensors on a device."""

from typing import Any

import numpy as np
import torch

from slider.core.arrays import Array, Random


def generator(seed: int, like: Array) -> Random:
    """Random numbers beside ``like``; each library has its own."""
    if isinstance(like, np.ndarray):
        return np.random.default_rng(seed)
    return DeviceRandom(seed, like)


class DeviceRandom:
    """Random numbers that are made on the device of ``like``, in its precision."""

    def __init__(self, seed: int, like: Any) -> None:
        self._generator = torch.Generator(like.device).manual_seed(seed)
        self._where: dict[str, Any] = {"dtype": like.dtype, "device": like.device}

    def uniform(self, low: Any = 0.0, high: Any = 1.0, size: Any = ()) -> torch.Tensor:
        """Uniform numbers in [low, high) of a shape."""
        share = torch.rand(size, generator=self._generator, **self._where)
        return low + (high - low) * share

    def standard_normal(self, size: Any = ()) -> torch.Tensor:
        """Standard normal numbers of a shape."""
        return torch.randn(size, generator=self._generator, **self._where)


def from_torch(tensor: torch.Tensor, like: Array) -> Array:
    """A tensor as an array beside ``like``: floats in its precision, others in their own."""
    if isinstance(like, np.ndarray):
        array = tensor.numpy()
        return array.astype(like.dtype) if tensor.is_floating_point() else array
    where: Any = like
    dtype = where.dtype if tensor.is_floating_point() else tensor.dtype
    return tensor.to(where.device, dtype)  # type: ignore[return-value]


def to_torch(array: Array, dtype: torch.dtype) -> torch.Tensor:
    """An array as a tensor where it is."""
    return torch.as_tensor(array).to(dtype)
