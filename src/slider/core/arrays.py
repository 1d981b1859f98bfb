"""Common formulas for NumPy arrays and torch tensors, and rows of batches of arrays.

MuJoCo's arrays are NumPy's; environment and learning use torch. Formulas for both use operators,
methods and functions with the same name in both libraries: ``xp = namespace(x); xp.exp(x)``.
"""

import copy
import sys
from dataclasses import fields, is_dataclass, replace
from typing import Any, TypeAlias, TypeVar

import numpy as np

Array: TypeAlias = Any
"""An array of NumPy or a tensor of torch."""
T = TypeVar("T")


def namespace(array: Array) -> Any:
    """Library of an array: ``numpy`` or ``torch``, without importing the latter."""
    return sys.modules[type(array).__module__]


def asarray(values: Any, like: Array) -> Array:
    """Convert numbers to the library, precision and device of ``like``."""
    return namespace(like).asarray(values, dtype=like.dtype, device=like.device)


def zeros(shape: tuple[int, ...] | int, like: Array) -> Array:
    """Zeros in the library, precision and on the device of ``like``."""
    return namespace(like).zeros(shape, dtype=like.dtype, device=like.device)


def tensors(batch: T, like: Any) -> T:
    """Convert the NumPy arrays of a dataclass, and of dataclasses in it, to tensors.

    Floats get the precision of ``like``, everything its device. Where both agree already, the
    tensors share the memory of the arrays.
    """
    torch, converted = namespace(like), {}
    for field in fields(batch):  # type: ignore[arg-type]
        value = getattr(batch, field.name)
        if isinstance(value, np.ndarray):
            dtype = like.dtype if value.dtype.kind == "f" else None
            converted[field.name] = torch.asarray(value, dtype=dtype, device=like.device)
        elif is_dataclass(value):
            converted[field.name] = tensors(value, like)
    return replace(batch, **converted)  # type: ignore[type-var]


def consecutive(indices: np.ndarray) -> np.ndarray | slice:
    """Increasing row ``indices`` (n,), as a slice if they are contiguous."""
    gapless = len(indices) and indices[-1] - indices[0] == len(indices) - 1
    return slice(indices[0], indices[-1] + 1) if gapless else indices


def take(batch: T, indices: np.ndarray | slice) -> T:
    """Rows of all arrays of a dataclass and of nested dataclasses; views if given a slice."""
    rows = copy.copy(batch)
    for name, value in _parts(batch):
        part = value[indices] if isinstance(value, np.ndarray) else take(value, indices)
        object.__setattr__(rows, name, part)
    return rows


def scatter(batch: T, indices: np.ndarray, rows: T) -> None:
    """Overwrite the rows ``indices`` of all arrays with those of another batch."""
    for name, value in _parts(batch):
        if isinstance(value, np.ndarray):
            value[indices] = getattr(rows, name)
        else:
            scatter(value, indices, getattr(rows, name))


def _parts(batch: Any) -> list[tuple[str, Any]]:
    """Arrays and nested dataclasses."""
    parts = [(item.name, getattr(batch, item.name)) for item in fields(batch)]
    return [(n, v) for n, v in parts if isinstance(v, np.ndarray) or is_dataclass(v)]
