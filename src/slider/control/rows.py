"""Rows of dataclasses whose arrays have one row per robot."""

import copy
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar

import numpy as np

T = TypeVar("T")


def consecutive(index: np.ndarray) -> np.ndarray | slice:
    """The rows ``index`` (n,), increasing, as a slice where none is left out."""
    whole = len(index) and index[-1] - index[0] == len(index) - 1
    return slice(index[0], index[-1] + 1) if whole else index


def take(batch: T, index: np.ndarray | slice) -> T:
    """The rows ``index`` of all arrays, nested dataclasses included; a slice copies none."""
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
