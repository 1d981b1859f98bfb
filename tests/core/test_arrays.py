"""Rows of nested dataclasses of arrays."""

from dataclasses import dataclass

import numpy as np
import pytest

from slider.core.arrays import consecutive, scatter, take


@dataclass(frozen=True)
class Inner:
    values: np.ndarray


@dataclass
class Outer:
    name: str
    numbers: np.ndarray
    inner: Inner


def outer() -> Outer:
    return Outer("steps", np.arange(4.0), Inner(np.arange(8.0).reshape(4, 2)))


def test_consecutive_rows_are_not_copied():
    whole = outer()
    some = take(whole, consecutive(np.array([1, 2])))
    some.inner.values[:] = -1
    assert some.numbers.tolist() == [1.0, 2.0]
    assert whole.inner.values[:, 0].tolist() == [0.0, -1.0, -1.0, 6.0]


@pytest.mark.parametrize("rows", [[], [2], [1, 3], [0, 1, 3]])
def test_rows_are_the_same_consecutive_or_not(rows):
    assert take(outer(), consecutive(np.array(rows, dtype=int))).numbers.tolist() == rows


def test_rows_are_put_back_and_the_others_stay():
    whole, index = outer(), np.array([3, 1])
    some = take(whole, index)
    some.numbers += 10
    some.inner.values[:] = -1
    scatter(whole, index, some)
    assert whole.numbers.tolist() == [0.0, 11.0, 2.0, 13.0]
    assert whole.inner.values[:, 0].tolist() == [0.0, -1.0, 4.0, -1.0]
