"""One set of terms for two array libraries: NumPy's arrays, and torch's tensors on any device.

Operators and methods that both have need nothing (``abs(x)``, ``x.sum(axis=1)``, ``x.clip(0, 1)``).
Functions are those of the array API: ``xp = namespace(x); xp.exp(-x)``.

Some robots out of N are an *index*: with NumPy the numbers (n,) of these robots, with torch a mask
(N,), so that shapes never depend on values, and the rows that belong to it are those of all robots.
"""

import weakref
from dataclasses import fields, is_dataclass, replace
from functools import lru_cache
from typing import Any, Protocol, TypeVar

import numpy as np
from array_api_compat import array_namespace

Array = np.ndarray  # for type checkers; a tensor has the same operators
NUMPY = np.zeros(0)  # to be like
T = TypeVar("T")
_CONSTANTS: dict[tuple[int, Any, Any], Array] = {}  # by the identity of arrays that live on


class Random(Protocol):
    """Random numbers: NumPy's generator, or one of a device with these methods of it.

    Numbers for an index have ``len(index)`` rows: n with NumPy, N with torch.
    """

    def uniform(self, low: Any = 0.0, high: Any = 1.0, size: Any = None) -> Any:
        """Uniform numbers in [low, high) of a shape."""

    def standard_normal(self, size: Any = None) -> Any:
        """Standard normal numbers of a shape."""


def namespace(*arrays: Array) -> Any:
    """The library of arrays; NumPy itself for its own."""
    return np if isinstance(arrays[0], np.ndarray) else array_namespace(*arrays)


def asarray(values: Any, like: Array) -> Array:
    """Values in the library and on the device of ``like``, floats in its precision."""
    values = np.asarray(values)
    if isinstance(like, np.ndarray):
        return values
    dtype = like.dtype if values.dtype.kind == "f" else None
    return namespace(like).asarray(values.copy(), dtype=dtype, device=like.device)


def constant(values: Any, like: Array) -> Array:
    """As :func:`asarray`, of values that never change: they go to a device once."""
    if isinstance(like, np.ndarray):
        return np.asarray(values)
    key = id(values), like.dtype, like.device
    if key in _CONSTANTS:
        return _CONSTANTS[key]
    array = np.asarray(values)
    found = _constant(
        array.tobytes(), array.shape, array.dtype, namespace(like), like.dtype, like.device
    )
    if array is values:
        _CONSTANTS[key] = found
        weakref.finalize(values, _CONSTANTS.pop, key, None)
    return found


@lru_cache(256)
def _constant(
    content: bytes, shape: tuple[int, ...], kind: np.dtype, library: Any, dtype: Any, device: Any
) -> Array:
    values = np.frombuffer(content, kind).reshape(shape).copy()
    dtype = dtype if kind.kind == "f" else None
    return library.asarray(values, dtype=dtype, device=device)


def beside(batch: T, like: Array) -> T:
    """A dataclass with all its NumPy arrays, and those of dataclasses in it, made :func:`asarray`.

    A dataclass whose arrays are NumPy's stays itself beside one of them.
    """
    if isinstance(like, np.ndarray) or not is_dataclass(batch) or isinstance(batch, type):
        return batch
    found = {field.name: getattr(batch, field.name) for field in fields(batch)}
    moved = {
        name: asarray(value, like) if isinstance(value, np.ndarray) else beside(value, like)
        for name, value in found.items()
    }
    return replace(batch, **moved)


def zeros(shape: tuple[int, ...] | int, like: Array, dtype: Any = None) -> Array:
    """Zeros beside ``like``."""
    return namespace(like).zeros(shape, dtype=dtype or like.dtype, device=like.device)


def which(mask: Any) -> Any:
    """The index of the robots that a mask (N,) has."""
    return np.flatnonzero(mask) if isinstance(mask, np.ndarray) else mask


def everyone(count: int, like: Any) -> Any:
    """The index of all robots."""
    return which(zeros(count, like) == 0)


def rows(array: Any, index: Any) -> Any:
    """The rows that belong to an index."""
    return array if _is_mask(index) else array[index]


def put(array: Any, index: Any, values: Any) -> None:
    """Overwrite the rows of some robots, in place."""
    if _is_mask(index):
        mask = index.reshape(index.shape + (1,) * (array.ndim - 1))
        array[...] = namespace(array).where(mask, values, array)
    else:
        array[index] = values


def _is_mask(index: Array) -> bool:
    return index.dtype == namespace(index).bool
