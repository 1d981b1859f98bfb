"""Rows of batches: dataclasses of arrays (N, …), one row per robot."""

import copy
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar

import numpy as np

T = TypeVar("T")


def consecutive(indices: np.ndarray) -> np.ndarray | slice:
    """The rows ``indices`` (n,), increasing, as a slice if none is left out."""
    gapless = len(indices) and indices[-1] - indices[0] == len(indices) - 1
    return slice(indices[0], indices[-1] + 1) if gapless else indices


def take(batch: T, indices: np.ndarray | slice) -> T:
    """Rows of all arrays of a dataclass, nested dataclasses included; a slice copies none."""
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
