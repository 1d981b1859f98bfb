"""Rows of dataclasses whose arrays have one row per robot."""

import copy
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar

import numpy as np

T = TypeVar("T")


def take(batch: T, index: np.ndarray) -> T:
    """A copy with the rows ``index`` of all arrays, nested dataclasses included."""
    found = copy.copy(batch)
    for name, value in _parts(batch):
        part = value[index] if isinstance(value, np.ndarray) else take(value, index)
        object.__setattr__(found, name, part)
    return found


def put(batch: T, index: np.ndarray, rows: T) -> None:
    """Overwrite the rows ``index`` of all arrays with those of another batch."""
    for name, value in _parts(batch):
        if isinstance(value, np.ndarray):
            value[index] = getattr(rows, name)
        else:
            put(value, index, getattr(rows, name))


def _parts(batch: Any) -> list[tuple[str, Any]]:
    found = [(item.name, getattr(batch, item.name)) for item in fields(batch)]
    return [(n, v) for n, v in found if isinstance(v, np.ndarray) or is_dataclass(v)]
